//! Scene files as trees: includes and `$parameters` resolved, names in `snake_case`.

use std::cell::Cell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::element::Element;
use crate::scene::SceneError;
use crate::scene::text::{LineStarts, advice, decoded_xml, error_at, file_error};

const MAX_INCLUDES: usize = 16;
/// Most files that are included, each time counted.
const MAX_FILES: usize = 4096;
/// How deep elements may be nested.
const MAX_DEPTH: usize = 256;
/// Most bytes that parameters may be replaced by.
const MAX_REPLACED: usize = 16 << 20;

/// A scene file and its version.
pub(super) struct Document {
    pub root: Element,
    pub version: (u32, u32),
}

/// Reads a scene file with all it includes.
pub(super) fn read_document(file: &Path) -> Result<Document, SceneError> {
    let bytes = crate::files::read(file).map_err(|e| file_error(file, e.to_string()))?;
    let text = decoded_xml(&bytes).map_err(|why| file_error(file, why))?;
    parse_document(file, &text)
}

/// Parses the text of a scene file.
pub(super) fn parse_document(file: &Path, text: &str) -> Result<Document, SceneError> {
    let mut shared = Shared {
        folder: file.parent().unwrap_or(Path::new("")).to_owned(),
        parameters: HashMap::new(),
        files: 0,
        replaced: 0,
    };
    let root = parse(file, text, &mut shared, 0)?;
    if root.tag != "scene" {
        let message = format!("expected <scene version=\"…\">, found <{}>", root.tag);
        return Err(root.error(message));
    }
    let version = root.attribute("version").unwrap_or("0.5.0");
    let mut numbers = version.split('.').map(str::parse::<u32>);
    match (numbers.next(), numbers.next()) {
        (Some(Ok(major)), Some(Ok(minor))) => Ok(Document {
            version: (major, minor),
            root,
        }),
        _ => Err(root.error(format!("`{version}` is not a scene version like 3.0.0"))),
    }
}

/// What the files of a scene have in common.
struct Shared {
    /// That of the scene's own file.
    folder: PathBuf,
    /// Declared by `<default>`.
    parameters: HashMap<String, String>,
    /// Files included so far.
    files: usize,
    /// Bytes of all values that parameters stood in.
    replaced: usize,
}

/// Parses a file of a scene, included at a depth.
fn parse(
    file: &Path,
    text: &str,
    shared: &mut Shared,
    depth: usize,
) -> Result<Element, SceneError> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|e| {
        let at = e.pos();
        // The place stands before the message, or in its middle.
        let message = e.to_string().replace(&format!(" at {at}"), "");
        SceneError::At {
            file: file.to_owned(),
            line: at.row as usize,
            column: at.col as usize,
            message,
        }
    })?;
    let mut reader = Reader {
        file: Rc::new(file.to_owned()),
        lines: LineStarts::of(text),
        text,
        shared,
        depth,
    };
    reader.element(document.root_element(), 0)
}

struct Reader<'a> {
    file: Rc<PathBuf>,
    text: &'a str,
    lines: LineStarts<'a>,
    shared: &'a mut Shared,
    depth: usize,
}

impl Reader<'_> {
    fn element(&mut self, node: roxmltree::Node, nesting: usize) -> Result<Element, SceneError> {
        let (line, column) = self.lines.place(node.range().start);
        if nesting > MAX_DEPTH {
            let message = format!("elements are nested more than {MAX_DEPTH} deep");
            return Err(error_at(&self.file, self.text, node.range().start, message));
        }
        let tag = node.tag_name().name();
        let mut attributes = Vec::new();
        for attribute in node.attributes() {
            let mut value = self.substituted(attribute.value(), attribute.range().start)?;
            if attribute.name() == "name" && tag != "default" {
                value = snake_case(&value);
            }
            attributes.push((attribute.name().to_owned(), value));
        }
        let mut element = Element {
            tag: if tag == "lookAt" {
                "lookat".into()
            } else {
                tag.to_owned()
            },
            attributes,
            children: Vec::new(),
            file: self.file.clone(),
            line,
            column,
            used: Cell::new(false),
        };
        for child in node.children().filter(roxmltree::Node::is_element) {
            let child = self.element(child, nesting + 1)?;
            match child.tag.as_str() {
                "default" => {
                    let (name, value) = (child.required("name")?, child.required("value")?);
                    if name.is_empty() {
                        return Err(child.error("a <default> needs a name"));
                    }
                    self.shared
                        .parameters
                        .entry(name.to_owned())
                        .or_insert(value.to_owned());
                }
                "include" => element.children.extend(self.include(&child)?),
                _ => element.children.push(child),
            }
        }
        Ok(element)
    }

    /// Replaces `$name` by the declared default: of several names that fit, that of the longest, as in Mitsuba.
    fn substituted(&mut self, value: &str, offset: usize) -> Result<String, SceneError> {
        let mut out = String::with_capacity(value.len());
        let mut rest = value;
        while let Some(at) = rest.find('$') {
            out.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            let parameters = self.shared.parameters.iter();
            let fitting = parameters.filter(|(name, _)| rest.starts_with(name.as_str()));
            let end = match fitting.max_by_key(|(name, _)| name.len()) {
                Some((name, value)) => {
                    out.push_str(value);
                    self.shared.replaced += value.len();
                    name.len()
                }
                None => {
                    let known = self.shared.parameters.keys().map(String::as_str);
                    let mut known: Vec<&str> = known.collect();
                    known.sort_unstable();
                    let word = |c: char| !c.is_alphanumeric() && c != '_';
                    let name = &rest[..rest.find(word).unwrap_or(rest.len())];
                    let message = format!("`${name}` has no <default>; {}", advice(name, &known));
                    return Err(error_at(&self.file, self.text, offset, message));
                }
            };
            if self.shared.replaced > MAX_REPLACED {
                let message = format!(
                    "the parameters of the scene grow beyond {} MiB; do they name each other?",
                    MAX_REPLACED >> 20
                );
                return Err(error_at(&self.file, self.text, offset, message));
            }
            rest = &rest[end..];
        }
        out.push_str(rest);
        Ok(out)
    }

    /// The children of the root of an included file.
    fn include(&mut self, element: &Element) -> Result<Vec<Element>, SceneError> {
        if self.depth >= MAX_INCLUDES {
            return Err(element.error("files include each other without end"));
        }
        self.shared.files += 1;
        if self.shared.files > MAX_FILES {
            return Err(element.error(format!("more than {MAX_FILES} files are included")));
        }
        let name = element.required("filename")?;
        let beside = self.file.parent().unwrap_or(Path::new("")).join(name);
        let beside_scene = self.shared.folder.join(name);
        let path = match !beside.exists() && beside_scene.exists() {
            true => beside_scene,
            false => beside,
        };
        let fail = |why: String| element.error(format!("{}: {why}", path.display()));
        let bytes = crate::files::read(&path).map_err(|e| fail(e.to_string()))?;
        let text = decoded_xml(&bytes).map_err(fail)?;
        let root = parse(&path, &text, self.shared, self.depth + 1)?;
        Ok(if root.tag == "scene" {
            root.children
        } else {
            vec![root]
        })
    }
}

/// `toWorld` → `to_world`, `intIOR` → `int_ior`; names already in `snake_case` stay.
pub(super) fn snake_case(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 4);
    let mut before_lower = false;
    for c in name.chars() {
        if c.is_uppercase() && before_lower {
            out.push('_');
        }
        before_lower = c.is_lowercase() || c.is_ascii_digit();
        out.extend(c.to_lowercase());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse_text(text: &str) -> Result<Document, String> {
        parse_document(Path::new("s.xml"), text).map_err(|e| e.to_string())
    }

    #[test]
    fn names_become_snake_case() {
        for (camel, snake) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("diffuseReflectance", "diffuse_reflectance"),
            ("to_world", "to_world"),
            ("alphaU", "alpha_u"),
            ("p0", "p0"),
            ("color1", "color1"),
        ] {
            assert_eq!(snake_case(camel), snake);
        }
    }

    #[test]
    fn parameters_are_substituted_and_unknown_ones_named() {
        let document = parse_text(
            "<scene version='3.0.0'><default name='n' value='7'/><default name='n' value='8'/>\n<a type='$n' value='x${n}'/></scene>",
        );
        assert!(document.is_err(), "braces are not a name");
        let document = parse_text("<scene version='3.0.0'><default name='n' value='7'/><default name='n' value='8'/>\n<a type='$n'/></scene>").unwrap();
        assert_eq!(document.root.children[0].kind(), "7");
        assert_eq!(document.version, (3, 0));
        let error = parse_text(
            "<scene version='3.0.0'><default name='depth' value='7'/>\n  <a type='$dept'/></scene>",
        )
        .err()
        .unwrap();
        assert!(error.starts_with("s.xml:2:"), "{error}");
        assert!(error.contains("did you mean `depth`"), "{error}");
    }

    #[test]
    fn errors_have_places() {
        let error = parse_text("<scene version='3.0.0'>\n  <a></b>\n</scene>")
            .err()
            .unwrap();
        assert!(error.starts_with("s.xml:2:"), "{error}");
        let error = parse_text("<mesh/>").err().unwrap();
        assert!(error.starts_with("s.xml:1:1: expected <scene"), "{error}");
        let document =
            parse_text("<scene version='0.5.0'><a>\n <float name='fov' value='x'/></a></scene>")
                .unwrap();
        let error = document.root.children[0]
            .float("fov")
            .unwrap_err()
            .to_string();
        assert_eq!(error, "s.xml:2:2: `x` in value=\"x\" is not a number");
    }

    #[test]
    fn what_grows_without_bounds_is_refused() {
        let deep = format!(
            "<scene version='3.0.0'>{}{}</scene>",
            "<a>".repeat(300),
            "</a>".repeat(300)
        );
        let error = parse_text(&deep).err().unwrap();
        assert!(error.contains("nested more than 256 deep"), "{error}");
        let mut bomb = "<scene version='3.0.0'><default name='a0' value='xxxxxxxxxx'/>".to_owned();
        for i in 1..12 {
            let ten = format!("$a{}", i - 1).repeat(10);
            bomb += &format!("<default name='a{i}' value='{ten}'/>");
        }
        let error = parse_text(&(bomb + "</scene>")).err().unwrap();
        assert!(error.contains("grow beyond 16 MiB"), "{error}");
    }

    #[test]
    fn includes_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = |i: usize| folder.path().join(format!("{i}.xml"));
        for i in 0..15 {
            let four = format!("<include filename='{}.xml'/>", i + 1).repeat(4);
            std::fs::write(path(i), format!("<scene version='3.0.0'>{four}</scene>")).unwrap();
        }
        std::fs::write(path(15), "<scene version='3.0.0'/>").unwrap();
        let error = read_document(&path(0)).err().unwrap().to_string();
        assert!(error.contains("more than 4096 files"), "{error}");
    }

    #[test]
    fn includes_are_spliced_and_loops_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(
            path("b.xml"),
            "<scene version='3.0.0'><b type='$t'/><c/></scene>",
        )
        .unwrap();
        std::fs::write(path("a.xml"), "<scene version='3.0.0'><default name='t' value='q'/><include filename='b.xml'/><d/></scene>").unwrap();
        let document = read_document(&path("a.xml")).unwrap();
        let tags: Vec<&str> = document
            .root
            .children
            .iter()
            .map(|c| c.tag.as_str())
            .collect();
        assert_eq!(tags, ["b", "c", "d"]);
        std::fs::create_dir(path("parts")).unwrap();
        std::fs::write(
            path("parts/e.xml"),
            "<scene version='3.0.0'><include filename='b.xml'/></scene>",
        )
        .unwrap();
        std::fs::write(path("f.xml"), "<scene version='3.0.0'><default name='t' value='q'/><include filename='parts/e.xml'/></scene>").unwrap();
        let document = read_document(&path("f.xml")).unwrap();
        assert_eq!(document.root.children.len(), 2, "beside the scene as well");
        std::fs::write(
            path("b.xml"),
            "<scene version='3.0.0'><include filename='b.xml'/></scene>",
        )
        .unwrap();
        let error = read_document(&path("a.xml")).err().unwrap().to_string();
        assert!(error.contains("without end"), "{error}");
    }
}
