//! Sizes of images, and parts of them.

/// Width and height in pixels, or in units of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels of a row.
    pub width: usize,
    /// Pixels of a column.
    pub height: usize,
}

/// A rectangle in pixels, or in units of a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Rect {
    /// The leftmost column.
    pub x: usize,
    /// The topmost row.
    pub y: usize,
    /// Pixels of a row.
    pub width: usize,
    /// Pixels of a column.
    pub height: usize,
}

impl Size {
    /// So many pixels wide and high.
    pub const fn new(width: usize, height: usize) -> Self {
        Self { width, height }
    }
}

impl Rect {
    /// A rectangle of a size, its top left pixel in column `x` and row `y`.
    pub const fn new(x: usize, y: usize, size: Size) -> Self {
        Self {
            x,
            y,
            width: size.width,
            height: size.height,
        }
    }
}
