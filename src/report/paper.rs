//! A drawing on paper: the SVG, and PNG and PDF made of it, with the embedded typefaces.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::ID;
use resvg::usvg::{Group, ImageRendering, Node, Options, Rect, Tree};
use svg2pdf::{ConversionOptions, PageOptions};

use super::font::Fonts;
use super::sheet::Sheet;
use crate::files;
use crate::image::{Size, write_png_bytes};

/// Of SVG: a pixel is one of these parts of an inch.
const DPI: f32 = 96.0;

/// A sheet and how large it is printed.
pub struct Print<'a> {
    pub sheet: &'a Sheet,
    pub width_mm: f64,
    /// Of the PNG in a unit of the sheet, along one side.
    pub pixels: usize,
}

/// Writes `name` with the endings svg, png and pdf into a folder. Returns what is wrong with its texts, or
/// why it cannot be drawn.
pub fn write(
    folder: &Path,
    name: &str,
    fonts: &Fonts,
    print: &Print,
) -> io::Result<Result<Vec<String>, String>> {
    let &Print {
        sheet,
        width_mm,
        pixels,
    } = print;
    let svg = sheet.svg(width_mm);
    let size = Size::new(sheet.width * pixels, sheet.height * pixels);
    let made = tree(&svg, fonts)
        .and_then(|tree| Ok((rgb(&tree, size)?, pdf(&tree)?, clashes(&tree, sheet))));
    let (bytes, pdf, clashes) = match made {
        Ok(made) => made,
        Err(reason) => return Ok(Err(reason)),
    };
    let file = |ending: &str| folder.join(format!("{name}.{ending}"));
    files::write(&file("svg"), svg)?;
    files::write(&file("pdf"), pdf)?;
    write_png_bytes(&file("png"), size, &bytes).map_err(io::Error::other)?;
    Ok(Ok(clashes))
}

fn tree(svg: &str, fonts: &Fonts) -> Result<Tree, String> {
    let options = Options {
        fontdb: fonts.database.clone(),
        // Pixels of pictures are pixels of the PNG.
        image_rendering: ImageRendering::OptimizeSpeed,
        dpi: DPI,
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(|e| format!("a figure cannot be read: {e}"))
}

/// Three bytes a pixel, row-major.
fn rgb(tree: &Tree, size: Size) -> Result<Vec<u8>, String> {
    let Size { width, height } = size;
    let side = |n: usize| u32::try_from(n).map_err(|e| e.to_string());
    let pixmap = Pixmap::new(side(width)?, side(height)?);
    let mut pixmap = pixmap.ok_or_else(|| format!("no figure has {width} × {height} pixels"))?;
    let drawn = tree.size();
    let transform =
        Transform::from_scale(width as f32 / drawn.width(), height as f32 / drawn.height());
    resvg::render(tree, transform, &mut pixmap.as_mut());
    // The sheet is white: nothing is translucent.
    let pixels = pixmap.data().chunks_exact(4);
    Ok(pixels.flat_map(|p| [p[0], p[1], p[2]]).collect())
}

/// Text stays text where it is of one typeface; `svg2pdf` writes several in any order, so that bytes would differ.
fn pdf(tree: &Tree) -> Result<Vec<u8>, String> {
    let mut faces = HashSet::new();
    each_text(tree.root(), &mut |text| {
        let glyphs = text.layouted().iter().flat_map(|s| &s.positioned_glyphs);
        faces.extend(glyphs.map(|glyph| glyph.font));
    });
    let conversion = ConversionOptions {
        embed_text: HashSet::<ID>::len(&faces) < 2,
        ..ConversionOptions::default()
    };
    let mut pdf = svg2pdf::to_pdf(tree, conversion, PageOptions { dpi: DPI })
        .map_err(|e| format!("a figure cannot be written as PDF: {e}"))?;
    sort_resources(&mut pdf);
    Ok(pdf)
}

/// `svg2pdf` lists the resources of a page in any order. Sorted, they take the same room, and nothing else moves.
fn sort_resources(pdf: &mut [u8]) {
    let find = |bytes: &[u8], text: &[u8]| bytes.windows(text.len()).position(|w| w == text);
    let is_entry = |line: &&[u8]| line.ends_with(b" R\n");
    let mut from = 0;
    while let Some(start) = find(&pdf[from..], b"/Resources <<") {
        from += start;
        let Some(length) = find(&pdf[from..], b"/ProcSet") else {
            return;
        };
        let block = pdf[from..from + length].to_vec();
        let mut lines: Vec<&[u8]> = block.split_inclusive(|byte| *byte == b'\n').collect();
        for run in lines.chunk_by_mut(|a, b| is_entry(a) == is_entry(b)) {
            if run.first().is_some_and(is_entry) {
                run.sort_unstable();
            }
        }
        pdf[from..from + length].copy_from_slice(&lines.concat());
        from += length;
    }
}

fn each_text(group: &Group, told: &mut impl FnMut(&resvg::usvg::Text)) {
    for node in group.children() {
        match node {
            Node::Group(group) => each_text(group, told),
            Node::Text(text) => told(text),
            Node::Path(_) | Node::Image(_) => {}
        }
    }
}

/// Texts that leave the sheet, and texts that lie on one another, by the outlines of their letters.
fn clashes(tree: &Tree, sheet: &Sheet) -> Vec<String> {
    let mut texts: Vec<(String, Rect)> = Vec::new();
    each_text(tree.root(), &mut |text| {
        let words = text.chunks().iter().map(|chunk| chunk.text());
        texts.push((words.collect(), text.abs_stroke_bounding_box()));
    });
    let size = tree.size();
    let slack = 0.5 * size.width() / sheet.width.max(1) as f32;
    let mut clashes = Vec::new();
    for (index, (text, a)) in texts.iter().enumerate() {
        let least = a.left().min(a.top());
        let most = (a.right() - size.width()).max(a.bottom() - size.height());
        if least < -slack || most > slack {
            clashes.push(format!("`{text}` leaves the sheet"));
        }
        for (other, b) in &texts[index + 1..] {
            let across = a.right().min(b.right()) - a.left().max(b.left());
            let down = a.bottom().min(b.bottom()) - a.top().max(b.top());
            if across > slack && down > slack {
                clashes.push(format!("`{text}` lies on `{other}`"));
            }
        }
    }
    clashes
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::image::Image;
    use crate::report::font::Align;
    use crate::report::sheet::with_square;

    fn drawn(texts: &[(&str, f32, f32)]) -> (Tree, Sheet, Fonts) {
        let (mut sheet, _, fonts) = with_square();
        let picture = |share| Image::new(8, 4).map(|_| [0.0, share, 1.0]);
        sheet.put(&picture(0.0), 100, 20);
        for index in 1_u8..5 {
            let share = f32::from(index) / 4.0;
            sheet.put(&picture(share), 100 + 20 * usize::from(index), 20);
        }
        for (text, x, y) in texts {
            let at = Vec2::new(*x, *y);
            sheet.text(&fonts, text, fonts.ink(1.0), at, Align::Left);
        }
        let tree = tree(&sheet.svg(85.0), &fonts).expect("a drawing");
        (tree, sheet, fonts)
    }

    #[test]
    fn pictures_and_shapes_reach_their_pixels() {
        let (tree, _, _) = drawn(&[]);
        let bytes = rgb(&tree, Size::new(200, 60)).expect("pixels");
        let at = |x: usize, y: usize| &bytes[3 * (y * 200 + x)..][..3];
        assert_eq!(at(20, 20), [255, 0, 0]);
        for (x, y) in [(100, 20), (107, 20), (107, 23), (100, 23)] {
            assert_eq!(at(x, y), [0, 0, 255], "{x} {y}");
        }
        assert_eq!(at(99, 20), [255; 3]);
        assert_eq!(at(108, 23), [255; 3]);
    }

    #[test]
    fn texts_on_one_another_and_beside_the_sheet_are_found() {
        let (tree, sheet, _) = drawn(&[("below", 40.0, 50.0), ("apart", 100.0, 50.0)]);
        assert!(clashes(&tree, &sheet).is_empty());
        let (tree, sheet, _) = drawn(&[
            ("below", 40.0, 50.0),
            ("above", 50.0, 52.0),
            ("out", 190.0, 20.0),
        ]);
        assert_eq!(clashes(&tree, &sheet).len(), 2);
    }

    #[test]
    fn equal_drawings_are_equal_files() {
        for text in ["plain", "two typefaces ↓"] {
            let pdfs = [0; 4].map(|_| pdf(&drawn(&[(text, 40.0, 50.0)]).0).expect("pdf"));
            assert!(pdfs.iter().all(|pdf| *pdf == pdfs[0]), "{text}");
            assert!(pdfs[0].starts_with(b"%PDF"));
        }
    }
}
