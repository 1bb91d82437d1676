//! Units of budgets: keys of configs, checks, estimates and what reports say follow from this table.

use std::fmt;

use super::Rendered;

/// What the contenders of a technique share an amount of.
pub struct Unit {
    /// Its key in configs, plans and rows.
    pub key: &'static str,
    /// What stands after the amount.
    pub heading: &'static str,
    /// Of what is spent: how much of the technique's first unit an amount pays for is found by trial. `None` for whole
    /// things that are counted out.
    pub spending: Option<Spending>,
    /// The largest amount that is taken.
    pub most: f64,
    /// Whether a config's amount is of an image at full size, and shrinks with its pixels.
    pub is_of_image: bool,
    /// What a single image of so many pixels gets unless it is told.
    pub usual: fn(pixels: f64) -> f64,
    /// Rays that an amount takes, camera rays included.
    pub rays: fn(amount: f64, image: &Casts) -> f64,
}

/// What images take of a unit that is spent.
pub struct Spending {
    /// What an image of so many pixels took.
    pub of: fn(&Rendered, pixels: f64) -> f64,
    /// Whether it is the same each time: then a budget is never exceeded, unless by the least count.
    pub is_counted: bool,
}

impl Spending {
    /// How far what was spent is from an amount, as a share of that: for choosing the nearest.
    pub fn missed(&self, spent: f64, amount: f64) -> f64 {
        match self.is_counted && spent > amount {
            // Behind all that is within.
            true => spent / amount,
            false => (spent - amount).abs() / amount,
        }
    }
}

/// What an image casts rays for.
#[derive(Clone, Copy, Debug)]
pub struct Casts {
    /// Of the image.
    pub pixels: f64,
    /// Camera samples of all pixels.
    pub samples: f64,
    /// Rays of one evaluation of the technique's function.
    pub rays_per_evaluation: f64,
}

/// What images of a given time count as in estimates, with those that the time is found by.
const RAYS_PER_SECOND: f64 = 2e7;

/// Images of about the budget's rays that a count is found by, and the one that is kept.
const TRIED: f64 = 4.0;

/// Records.
pub static CACHES: Unit = Unit {
    key: "caches",
    heading: "records",
    spending: None,
    // Records are counted in 32 bits; more than there are shading points are never made.
    most: u32::MAX as f64,
    is_of_image: true,
    // The records per pixel of 120,000 at full HD.
    usual: |pixels| (pixels * 120_000.0 / (1920.0 * 1080.0)).round().max(1.0),
    rays: |amount, image| image.pixels + image.samples + amount * image.rays_per_evaluation,
};

/// Shadow rays per shading point: lights at full resolution, or samples.
pub static LIGHTS: Unit = Unit {
    key: "lights",
    heading: "rays a point",
    spending: None,
    most: (1 << 20) as f64,
    is_of_image: false,
    usual: |_| 16.0,
    rays: |amount, image| image.samples * (1.0 + amount),
};

/// Paths through each pixel of a frame.
pub static SAMPLES: Unit = Unit {
    key: "samples",
    heading: "paths a pixel",
    spending: None,
    most: (1 << 24) as f64,
    is_of_image: false,
    usual: |_| 1.0,
    rays: |amount, image| image.pixels * amount * image.rays_per_evaluation,
};

/// Processor seconds of an image in all; how much of the technique's first unit they pay for is found.
pub static SECONDS: Unit = Unit {
    key: "seconds",
    heading: "CPU s",
    spending: Some(Spending {
        of: |image, _| {
            let total = image.stages.total();
            // Some systems tell no processor time.
            if total.cpu > 0.0 {
                total.cpu
            } else {
                total.wall
            }
        },
        is_counted: false,
    }),
    // A day.
    most: 86_400.0,
    is_of_image: false,
    usual: |_| 1.0,
    rays: |amount, image| image.samples + amount * RAYS_PER_SECOND,
};

/// Rays that an image casts in all, camera rays included, a pixel; how much of the technique's first unit they pay for is
/// found.
pub static RAYS_PER_PIXEL: Unit = Unit {
    key: "rays_per_pixel",
    heading: "rays a pixel",
    spending: Some(Spending {
        of: |image, pixels| image.rays.all() as f64 / pixels.max(1.0),
        is_counted: true,
    }),
    most: 1e9,
    is_of_image: false,
    usual: |_| 16.0,
    rays: |amount, image| TRIED * image.pixels * amount,
};

/// Every unit.
pub static UNITS: [&Unit; 5] = [&CACHES, &LIGHTS, &SAMPLES, &SECONDS, &RAYS_PER_PIXEL];

impl PartialEq for Unit {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key
    }
}

impl fmt::Debug for Unit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.key)
    }
}
