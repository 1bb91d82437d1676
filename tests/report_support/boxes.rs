//! Where the texts of figures stand: no letter may be cut, and no text may lie on another one.

use std::path::Path;

use roxmltree::{Document, Node};

/// A text of a figure.
#[derive(Debug)]
pub struct Written {
    pub text: String,
    /// Units of the drawing.
    pub size: f64,
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

/// All texts of a drawing, and its size.
pub fn texts(svg: &str) -> (Vec<Written>, (f64, f64)) {
    let document = Document::parse(svg).expect("a drawing");
    let root = document.root_element();
    let view = root.attribute("viewBox").expect("a view box");
    let ends: Vec<f64> = view
        .split(' ')
        .map(|n| n.parse().expect("a number"))
        .collect();
    let texts = root.descendants().filter(|node| node.has_tag_name("text"));
    (texts.map(written).collect(), (ends[2], ends[3]))
}

/// Letters reach from 0.74 of their size above the baseline to 0.2 below.
fn written(node: Node) -> Written {
    let number = |name| node.attribute(name).and_then(|n| n.parse::<f64>().ok());
    let [x, y, size, width] = ["x", "y", "font-size", "textLength"].map(|n| number(n).expect(n));
    let before = match node.attribute("text-anchor") {
        Some("middle") => width / 2.0,
        Some("end") => width,
        _ => 0.0,
    };
    let (along, across) = ((-before, width - before), (-0.74 * size, 0.2 * size));
    let is_upright = node.attribute("transform").is_some();
    let ((left, right), (top, bottom)) = match is_upright {
        true => (across, (-along.1, -along.0)),
        false => (along, across),
    };
    Written {
        text: node.text().unwrap_or_default().to_owned(),
        size,
        left: x + left,
        top: y + top,
        right: x + right,
        bottom: y + bottom,
    }
}

/// Checks every drawing of a results folder and returns how many there are.
pub fn assert_legible(folder: &Path) -> usize {
    let mut count = 0;
    for entry in std::fs::read_dir(folder.join("figures")).expect("figures") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|ending| ending == "svg") {
            let svg = std::fs::read_to_string(&path).expect("readable");
            let clashes = clashes(&svg);
            assert!(clashes.is_empty(), "{}: {clashes:#?}", path.display());
            count += 1;
        }
    }
    count
}

fn clashes(svg: &str) -> Vec<String> {
    let (texts, (width, height)) = texts(svg);
    let mut clashes = Vec::new();
    for (index, a) in texts.iter().enumerate() {
        if a.left < 0.0 || a.top < 0.0 || a.right > width || a.bottom > height {
            clashes.push(format!("{a:?} leaves {width} × {height}"));
        }
        for b in &texts[index + 1..] {
            let across = a.right.min(b.right) - a.left.max(b.left);
            let down = a.bottom.min(b.bottom) - a.top.max(b.top);
            if across > 0.0 && down > 0.0 {
                clashes.push(format!("{a:?} lies on {b:?}"));
            }
        }
    }
    clashes
}
