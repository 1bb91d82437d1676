//! The XML tree of a Mitsuba scene.

use std::cell::Cell;
use std::path::PathBuf;
use std::rc::Rc;

use crate::scene::SceneError;

/// An element with everything substituted. The names of parameters, as values of the attribute
/// `name`, are in `snake_case` whatever the version of the file.
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub file: Rc<PathBuf>,
    pub line: usize,
    pub column: usize,
    /// Whether the importer has looked at it; what it never looks at is reported.
    pub used: Cell<bool>,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes
            .iter()
            .find(|(n, _)| n == name)
            .map(|(_, v)| v.as_str())
    }

    /// The names of its attributes.
    pub fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.attributes.iter().map(|(name, _)| name.as_str())
    }

    /// The plugin: attribute `type`.
    pub fn kind(&self) -> &str {
        self.attribute("type").unwrap_or("")
    }

    /// The parameter name, empty if anonymous.
    pub fn name(&self) -> &str {
        self.attribute("name").unwrap_or("")
    }

    pub fn id(&self) -> Option<&str> {
        self.attribute("id")
    }

    /// The child of this parameter name, marked as used.
    pub fn child(&self, name: &str) -> Option<&Element> {
        let child = self.children.iter().find(|c| c.name() == name)?;
        child.used.set(true);
        Some(child)
    }

    /// All children with a tag.
    pub fn tagged<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| c.tag == tag)
    }

    /// An error at this element.
    pub fn error(&self, message: impl Into<String>) -> SceneError {
        SceneError::At {
            file: self.file.to_path_buf(),
            line: self.line,
            column: self.column,
            message: message.into(),
        }
    }

    /// The attribute or an error that names it.
    pub fn required(&self, attribute: &str) -> Result<&str, SceneError> {
        self.attribute(attribute)
            .ok_or_else(|| self.error(format!("<{}> needs the attribute `{attribute}`", self.tag)))
    }

    /// The numbers in an attribute, separated by commas or white space.
    pub fn numbers(&self, attribute: &str) -> Result<Vec<f64>, SceneError> {
        let text = self.required(attribute)?;
        let words = text
            .split([',', ' ', '\t', '\n', '\r', ';'])
            .filter(|w| !w.is_empty());
        words
            .map(|w| {
                w.parse().map_err(|_| {
                    self.error(format!(
                        "`{w}` in {attribute}=\"{}\" is not a number",
                        clip(text)
                    ))
                })
            })
            .collect()
    }

    /// The float (or integer) parameter of this name.
    pub fn float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        let Some(child) = self.child(name) else {
            return Ok(None);
        };
        match child.numbers("value")?[..] {
            [x] => Ok(Some(x)),
            _ => Err(child.error(format!("`{name}` must be one number"))),
        }
    }

    /// The parameter of this name, a whole number not below 0.
    pub fn whole(&self, name: &str) -> Result<Option<usize>, SceneError> {
        match self.float(name)? {
            None => Ok(None),
            Some(x) if x >= 0.0 && x.fract() == 0.0 && x <= f64::from(u32::MAX) => {
                Ok(Some(x as usize))
            }
            Some(x) => {
                let message = format!("`{name}` must be a whole number from 0, not {x}");
                Err(self.child(name).unwrap_or(self).error(message))
            }
        }
    }

    /// The boolean parameter of this name.
    pub fn boolean(&self, name: &str, default: bool) -> Result<bool, SceneError> {
        let Some(child) = self.child(name) else {
            return Ok(default);
        };
        match child
            .required("value")?
            .trim()
            .to_ascii_lowercase()
            .as_str()
        {
            "true" => Ok(true),
            "false" => Ok(false),
            other => Err(child.error(format!("`{name}` must be true or false, not `{other}`"))),
        }
    }

    /// The string parameter of this name.
    pub fn string(&self, name: &str) -> Result<Option<&str>, SceneError> {
        self.child(name)
            .map(|c| c.required("value").map(str::trim))
            .transpose()
    }

    /// Marks the whole subtree as looked at.
    pub fn mark_all(&self) {
        self.used.set(true);
        self.children.iter().for_each(Element::mark_all);
    }
}

/// At most forty characters of a value, for messages.
fn clip(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}
