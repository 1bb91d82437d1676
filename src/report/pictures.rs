//! The images that jobs left behind.

use std::collections::BTreeSet;
use std::path::Path;

use super::data::{Asked, Data, SceneOf};
use crate::environment::LightKind;
use crate::experiment::{LIGHTS_FILE, LightFile, MAP_FILE, Row};
use crate::image::{Image, Plane, Samples, luminance, read_coded, read_layers};

/// The layers of one job's `image.exr` that figures show.
pub struct Pictures<'a> {
    pub row: &'a Row,
    pub beauty: Image,
    pub reference: Option<Image>,
    /// 1 first stage, 2 refinement, 0 no record.
    pub records: Option<Plane>,
    pub flip: Option<Plane>,
    pub discontinuity: Option<Plane>,
    /// Numbers of the cells that pixels show, 0 without one.
    pub cells: Option<Plane>,
    /// Kept when the config asks for a figure of them.
    pub lights: Option<LightPictures>,
    /// Stops.
    pub exposure: f32,
}

/// What a job kept of its lights.
pub struct LightPictures {
    /// The map, tone-mapped and coded.
    pub map: Image,
    /// Map coordinates in [0, 1] and kinds.
    pub lights: Vec<([f32; 2], LightKind)>,
    /// Pixels of the map with emissive texels.
    pub emissive: BTreeSet<u32>,
}

impl LightPictures {
    /// `None` where a job kept none.
    fn read(folder: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(folder.join(LIGHTS_FILE)).ok()?;
        let file: LightFile = serde_json::from_str(&text).ok()?;
        let (map, _) = read_coded(&folder.join(MAP_FILE)).ok()?;
        Some(Self {
            map,
            emissive: file.emissive_pixels(),
            lights: file.lights,
        })
    }
}

/// The pictures of every method of a scene, in the order of the methods: of the first seed and the
/// first swept value. Absent ones are `None`, with a reason in `notes` unless the job did not finish.
pub fn of_scene<'a>(
    data: &'a Data,
    scene: &'a SceneOf,
    notes: &mut Vec<String>,
) -> Vec<Option<Pictures<'a>>> {
    let mut size = None;
    data.labels()
        .iter()
        .map(|label| {
            let asked = Asked {
                scene,
                label,
                point: &data.points()[0],
            };
            let row = data.cases.rows_of(&data.case(asked)).next()?;
            let pictures = read(data, row).map_err(|reason| notes.push(reason)).ok()?;
            let here = (pictures.beauty.width, pictures.beauty.height);
            if *size.get_or_insert(here) != here {
                notes.push(format!(
                    "{} {label}: its image has another size than the others",
                    scene.name
                ));
                return None;
            }
            Some(pictures)
        })
        .collect()
}

fn read<'a>(data: &Data, row: &'a Row) -> Result<Pictures<'a>, String> {
    let path = data.store.job_folder(&row.job).join("image.exr");
    let file = read_layers(&path)
        .map_err(|e| format!("{} {}: {e}", data.cases.name_of(row), row.label))?;
    let mut pictures = Pictures {
        row,
        beauty: Image::default(),
        reference: None,
        records: None,
        flip: None,
        discontinuity: None,
        cells: None,
        lights: LightPictures::read(&data.store.job_folder(&row.job)),
        exposure: file
            .attributes
            .get("exposure")
            .and_then(serde_json::Value::as_f64)
            .unwrap_or(0.0) as f32,
    };
    // Of folders in which each job has its own copy the store is not asked.
    let key = file.attributes.get("reference");
    if let Some(key) = key.and_then(serde_json::Value::as_str)
        && file.layer("reference").is_none()
    {
        pictures.reference = data.references.mean(key);
    }
    for layer in file.layers {
        match (layer.name.as_str(), layer.samples) {
            ("", Samples::Color(image)) => pictures.beauty = image,
            ("reference", Samples::Color(image)) => pictures.reference = Some(image),
            ("records", Samples::Gray(plane)) => pictures.records = Some(plane),
            ("flip", Samples::Gray(plane)) => pictures.flip = Some(plane),
            ("discontinuity", Samples::Gray(plane)) => pictures.discontinuity = Some(plane),
            ("cells", Samples::Gray(plane)) => pictures.cells = Some(plane),
            _ => {}
        }
    }
    if pictures.beauty.pixels.is_empty() {
        return Err(format!(
            "{} {}: {} holds no picture",
            data.cases.name_of(row),
            row.label,
            path.display()
        ));
    }
    Ok(pictures)
}

impl Pictures<'_> {
    /// Absolute difference of the luminances; `None` without a reference.
    pub fn error(&self) -> Option<Plane> {
        let reference = self.reference.as_ref()?;
        let pairs = self.beauty.pixels.iter().zip(&reference.pixels);
        Some(Plane {
            width: self.beauty.width,
            height: self.beauty.height,
            values: pairs
                .map(|(a, b)| (luminance(*a) - luminance(*b)).abs())
                .collect(),
        })
    }
}

/// The value below which a share of all finite values lies; 0 without any.
pub fn quantile(planes: &[&Plane], share: f64) -> f32 {
    let mut values: Vec<f32> = planes
        .iter()
        .flat_map(|p| &p.values)
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    if values.is_empty() {
        return 0.0;
    }
    let index = ((values.len() - 1) as f64 * share).round() as usize;
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}
