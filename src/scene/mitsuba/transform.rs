//! `<transform>` chains.

use glam::{DMat4, DVec3};

use super::Importer;
use super::element::Element;
use crate::scene::SceneError;

impl Importer<'_> {
    /// As [`transform`], with a note on what of matrices is not used.
    pub(super) fn transform(&mut self, element: &Element) -> Result<DMat4, SceneError> {
        let product = transform(element)?;
        let mut steps = element.children.iter();
        if steps.any(|step| step.tag == "matrix" && has_odd_row(step)) {
            self.note(
                "of a `matrix` whose last row is not 0 0 0 1 nothing is used of that row, as in Mitsuba",
            );
        }
        Ok(product)
    }
}

/// Whether the last of four rows is not that of a map of places.
fn has_odd_row(matrix: &Element) -> bool {
    let numbers = matrix.numbers("value").unwrap_or_default();
    numbers.len() == 16 && numbers[12..] != [0.0, 0.0, 0.0, 1.0]
}

/// The product of a chain; each step is applied after those before it.
fn transform(element: &Element) -> Result<DMat4, SceneError> {
    element.used.set(true);
    let mut product = DMat4::IDENTITY;
    for step in &element.children {
        step.used.set(true);
        let matrix = match step.tag.as_str() {
            "matrix" => matrix(step)?,
            "translate" => DMat4::from_translation(vector(step, 0.0)?),
            "scale" => DMat4::from_scale(vector(step, 1.0)?),
            "rotate" => rotation(step)?,
            "lookat" => look_at(step)?,
            other => {
                return Err(step.error(format!(
                    "<{other}> is no transform; known: matrix, translate, scale, rotate, lookat"
                )));
            }
        };
        product = matrix * product;
    }
    if product.is_finite() {
        Ok(product)
    } else {
        Err(element.error("the transform is not finite"))
    }
}

/// `x`, `y`, `z` attributes, or `value` with one or three numbers.
pub(super) fn vector(element: &Element, default: f64) -> Result<DVec3, SceneError> {
    if element.attribute("value").is_some() {
        return match element.numbers("value")?[..] {
            [s] => Ok(DVec3::splat(s)),
            [x, y, z] => Ok(DVec3::new(x, y, z)),
            _ => Err(element.error("expected one or three numbers")),
        };
    }
    let mut result = [default; 3];
    for (value, axis) in result.iter_mut().zip(["x", "y", "z"]) {
        if element.attribute(axis).is_some() {
            match element.numbers(axis)?[..] {
                [number] => *value = number,
                _ => return Err(element.error(format!("`{axis}` must be one number"))),
            }
        }
    }
    Ok(DVec3::from(result))
}

fn matrix(element: &Element) -> Result<DMat4, SceneError> {
    let numbers = element.numbers("value")?;
    match numbers.len() {
        16 => {
            let rows: [f64; 16] = std::array::from_fn(|i| numbers[i]);
            Ok(DMat4::from_cols_array(&rows).transpose())
        }
        9 => {
            let at = |row: usize, column: usize| numbers[row * 3 + column];
            let column = |c: usize| DVec3::new(at(0, c), at(1, c), at(2, c)).extend(0.0);
            Ok(DMat4::from_cols(
                column(0),
                column(1),
                column(2),
                glam::DVec4::W,
            ))
        }
        n => Err(element.error(format!("a matrix has 16 (or 9) numbers, this one {n}"))),
    }
}

fn rotation(element: &Element) -> Result<DMat4, SceneError> {
    let axis = vector(element, 0.0)?.normalize_or_zero();
    let [angle_deg] = element.numbers("angle")?[..] else {
        return Err(element.error("`angle` must be one number"));
    };
    if axis == DVec3::ZERO {
        return Err(element.error("the rotation axis is zero"));
    }
    Ok(DMat4::from_axis_angle(axis, angle_deg.to_radians()))
}

/// Columns are left, up, forward (Mitsuba's camera frame).
fn look_at(element: &Element) -> Result<DMat4, SceneError> {
    let point = |name: &str| match element.numbers(name)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        _ => Err(element.error(format!("`{name}` must be three numbers"))),
    };
    let (origin, target) = (point("origin")?, point("target")?);
    let forward = (target - origin).normalize_or_zero();
    if forward == DVec3::ZERO {
        return Err(element.error("`origin` and `target` are the same point"));
    }
    let up = if element.attribute("up").is_some() {
        point("up")?
    } else {
        DVec3::ZERO
    };
    let left = match up.cross(forward).normalize_or_zero() {
        // Mitsuba's choice (Duff et al. 2017).
        DVec3::ZERO if up == DVec3::ZERO => forward.any_orthonormal_pair().0.cross(forward),
        DVec3::ZERO => return Err(element.error("`up` is parallel to the viewing direction")),
        left => left,
    };
    let up = forward.cross(left);
    Ok(DMat4::from_cols(
        left.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        origin.extend(1.0),
    ))
}
