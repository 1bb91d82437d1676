//! Every contender of every technique, and the small worlds that they are tried in.

use glam::{DAffine3, DMat4, DVec3};
use lightbench::entry::Bias;
use lightbench::environment::{Environment, EnvironmentOptions};
use lightbench::image::Image;
use lightbench::registry::TECHNIQUES;
use lightbench::scene::{Material, Scene, SceneDescription, ShapeDescription, ShapeSource, View};
use lightbench::technique::{
    Choice, Contender, Film, Listed as AsListed, Playing, Rendered, Shot, Technique,
    TechniqueEntry, Terms,
};
use lightbench::trace::Tracer;
use lightbench::world::{self, Moment, Motion};

/// A technique, one of its contenders, and parameters that make both cheap.
pub struct Listed {
    pub entry: &'static TechniqueEntry,
    pub technique: Box<dyn Technique>,
    pub id: String,
    pub biases: Vec<Bias>,
    parameters: toml::Table,
}

/// Parameters of a technique that make its references and records cheap.
pub fn cheap(id: &str) -> toml::Table {
    let text = match id {
        "ambient-occlusion" => "side = 8",
        "irradiance-caching" => "side = 8\nreference_passes = 64",
        "importance-caching" => "lights = 64",
        "environment-lighting" => "reference_samples = 256\nreference_passes = 4",
        "path-tracing" | "direct-lighting" | "radiance" => "reference_passes = 64",
        other => panic!("no cheap parameters for {other}: add them"),
    };
    text.parse().expect("toml")
}

/// A contender with parameters that make it cheap, once for each way that it has to work.
pub fn variants(listed: &AsListed) -> Vec<(&AsListed, toml::Table)> {
    let texts: &[&str] = match listed.id.as_str() {
        id if id.starts_with("SD") => &["min_cluster_size = 1"],
        "per-sample" => &["passes = 2"],
        "rt" => &["", "selection = 'product'"],
        _ => &[""],
    };
    let parsed = |text: &&str| (listed, text.parse().expect("toml"));
    texts.iter().map(parsed).collect()
}

pub fn all() -> Vec<Listed> {
    let mut all = Vec::new();
    for entry in TECHNIQUES {
        for (listed, parameters) in (entry.contenders)().iter().flat_map(variants) {
            let technique = (entry.build)(&cheap(entry.about.id)).expect("parameters");
            let started = technique.start(&listed.id, &parameters, Terms::default());
            match started.map(|started| started.id) {
                Ok(id) => assert_eq!(id, listed.id, "canonical"),
                Err(error) => {
                    // Gradients are no use to importance caching, and it says so.
                    assert_eq!(error.key, "interpolation", "{error}");
                    continue;
                }
            }
            all.push(Listed {
                entry,
                technique,
                id: listed.id.clone(),
                biases: listed.parts.iter().map(|part| part.bias).collect(),
                parameters,
            });
        }
    }
    all
}

impl Listed {
    pub fn name(&self) -> String {
        format!("{} {} {}", self.entry.about.id, self.id, self.parameters)
    }

    pub fn choice(&self, budget: usize, seed: u64) -> Choice<'_> {
        Choice {
            method: &self.id,
            parameters: &self.parameters,
            terms: Terms { budget, seed },
        }
    }

    /// A budget that every technique can afford.
    pub fn budget(&self) -> usize {
        match self.entry.units[0].key {
            "caches" => 24,
            "lights" => 4,
            "samples" => 2,
            other => panic!("no affordable number of {other}: add it"),
        }
    }

    pub fn remembers(&self) -> bool {
        self.started(Terms::default()).remembers()
    }

    pub fn started(&self, terms: Terms) -> Box<dyn Contender + '_> {
        self.playing(terms).contender
    }

    pub fn playing(&self, terms: Terms) -> Playing<'_> {
        let choice = self.choice(terms.budget, terms.seed);
        choice
            .play_from_start(self.technique.as_ref())
            .expect("starts")
    }

    /// What a viewer sees of a moment, whose exposure is that of a sequence which begins there.
    pub fn shot<'a>(&self, moment: Moment<'a>, viewer: u16, spp: u32) -> Shot<'a> {
        let view = &moment.scene.views[usize::from(viewer)];
        let film = Film {
            width: 16,
            height: 10,
            spp,
        };
        let technique = self.technique.as_ref();
        let mut shot = Shot::exposed_for(technique, moment, view, film);
        shot.viewer = viewer;
        shot.layer = technique.shared_layer(&shot);
        shot
    }

    /// What both viewers see of a moment.
    pub fn both<'a>(&self, moment: Moment<'a>, frame: u32) -> Vec<Shot<'a>> {
        let mut shots: Vec<Shot> = (0..2).map(|viewer| self.shot(moment, viewer, 1)).collect();
        shots.iter_mut().for_each(|shot| shot.frame = frame);
        shots
    }
}

/// Two views of a room with a lamp, open to the sky.
pub fn room(light: f32) -> SceneDescription {
    let shape = |name: &str, source, to_world| ShapeDescription {
        to_world,
        ..ShapeDescription::new(name, source)
    };
    let floor =
        DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2) * DMat4::from_scale(DVec3::splat(2.0));
    let block = DMat4::from_translation(DVec3::new(0.3, 0.4, -0.2))
        * DMat4::from_rotation_y(0.4)
        * DMat4::from_scale(DVec3::splat(0.4));
    let mut lamp = shape(
        "lamp",
        ShapeSource::Rectangle,
        DMat4::from_translation(DVec3::new(0.0, 2.5, 0.0))
            * DMat4::from_rotation_x(std::f64::consts::FRAC_PI_2)
            * DMat4::from_scale(DVec3::splat(0.5)),
    );
    lamp.emission = Some([light; 3]);
    let eye = |x: f64| [DVec3::new(x, 1.6, 3.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y];
    SceneDescription {
        name: "room".into(),
        max_depth: 6,
        views: vec![
            View::look_at("left", eye(-1.0), 50.0, [16, 10]),
            View::look_at("right", eye(1.2), 50.0, [16, 10]),
        ],
        materials: vec![Material::diffuse("grey", [0.6, 0.5, 0.4])],
        shapes: vec![
            shape("floor", ShapeSource::Rectangle, floor),
            shape("block", ShapeSource::Cube, block),
            lamp,
        ],
        ..SceneDescription::default()
    }
}

/// Nothing but what is seen: no surface in front of the camera.
pub fn nothing_seen() -> SceneDescription {
    let mut description = room(0.0);
    for view in &mut description.views {
        view.forward = -view.forward;
        view.right = -view.right;
    }
    description
}

pub struct World {
    scene: Scene,
    tracer: Tracer,
}

/// The scene under a sky that is brighter in one place.
pub fn under_sky(description: &SceneDescription, technique: &dyn Technique, sky: f32) -> Scene {
    let mut scene = Scene::build(description, technique.needs()).expect("a scene");
    let mut map = Image::new(8, 4);
    map.pixels.fill([sky; 3]);
    map.pixels[10] = [4.0 * sky; 3];
    scene.environment = technique
        .needs()
        .environment
        .then(|| Environment::from_image(&map, &EnvironmentOptions::default()).expect("a map"));
    scene
}

impl World {
    pub fn new(description: &SceneDescription, technique: &dyn Technique, sky: f32) -> Self {
        let scene = under_sky(description, technique, sky);
        let tracer = Tracer::new(&scene.positions, &scene.triangles);
        Self { scene, tracer }
    }

    /// The same without its shapes. No file gives such a scene: see the test that it is refused.
    pub fn emptied(mut self) -> Self {
        let scene = &mut self.scene;
        scene.positions.clear();
        scene.normals.clear();
        scene.uvs.clear();
        scene.triangles.clear();
        scene.triangle_shape.clear();
        scene.shapes.clear();
        self.tracer = Tracer::new(&scene.positions, &scene.triangles);
        self
    }

    pub fn shot(&self, listed: &Listed, viewer: u16, spp: u32) -> Shot<'_> {
        listed.shot(Moment::still(&self.scene, &self.tracer), viewer, spp)
    }
}

/// Everything of a result that must not depend on threads, viewers or frames.
pub fn fingerprint(rendered: &Rendered) -> String {
    let bits: Vec<[u32; 3]> = (rendered.image.pixels.iter())
        .map(|pixel| pixel.map(f32::to_bits))
        .collect();
    format!(
        "{bits:?} {:?} {} {:?} {}",
        rendered.rays, rendered.lookups, rendered.found, rendered.bytes_cache
    )
}

/// The room, whose block and lamp move and turn.
pub fn moving_room(technique: &dyn Technique) -> world::World {
    let moves = |shape: usize, way: DVec3| Motion {
        shape,
        place: Box::new(move |time_s| {
            DAffine3::from_translation(way * time_s) * DAffine3::from_rotation_y(0.7 * time_s)
        }),
    };
    let motions = vec![
        moves(1, DVec3::new(-0.9, 0.5, 0.3)),
        moves(2, DVec3::new(0.4, -0.3, 0.0)),
    ];
    let scene = under_sky(&room(8.0), technique, 0.5);
    world::World::moving(scene, motions, &[0.0, 1.0]).expect("a world")
}
