//! Every verb and flag.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

const NOTES: &str = "Exit codes: 0 ok · 2 usage or config · 3 nothing selected · 4 some jobs failed · \
10 gate failed · 11 gate inconclusive · 12 gate has no data · 130 interrupted (finished jobs kept)
Environment: LIGHTBENCH_SCENES path list of folders with scenes and maps · LIGHTBENCH_KERNEL how rays are \
traced: wide (default where the processor has AVX-512, or AVX2 and FMA), watertight, portable, or a kernel by \
the name it has in provenance.json · LIGHTBENCH_HIDE instructions not to use: avx512, avx2";

const DIFF_NOTES: &str = "Jobs belong together that have scene, view, technique, label, swept values and seed in common. For each \
contender in which something changed it prints errors, counted cost and CPU seconds before and after, the relative change of \
their mean, and whether that lies beyond the 95 % interval over seeds. What is the same to the last bit is left out. Where a \
run failed or is missing there is no data; a contender of one folder only is named. \
It exits with 0 whatever changed, and with 3 where the folders have no job in common: `gate` decides, `diff` tells.";

/// A laboratory for cached light: which method is better, by how much, at what cost, and is it
/// significant.
#[derive(Debug, Parser)]
#[command(name = "lightbench", version, after_help = NOTES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Run experiments: references, renderings, metrics, tables, figures, claims
    Run(RunArgs),
    /// Show the frozen job list, its estimated cost and what is already done
    Plan(PlanArgs),
    /// Rebuild tables, figures and the HTML report from rows, without rendering
    Report(ReportArgs),
    /// Evaluate claims and gates; the exit code says the result
    Gate(GateArgs),
    /// Compare the same jobs of two results folders
    Diff(DiffArgs),
    /// Unite the rows and jobs of several results folders (shards)
    Merge(MergeArgs),
    /// Render one image
    Render(RenderArgs),
    /// All metrics of two images
    Compare(CompareArgs),
    /// Write where a cached method has its records
    Caches(CachesArgs),
    /// The lights that a sampler makes of an environment map
    Lights(LightsArgs),
    /// Look at scenes
    #[command(subcommand)]
    Scene(SceneVerb),
    /// Write a commented experiment or scene to start from
    #[command(subcommand)]
    New(NewVerb),
    /// Look at and extend the reference store
    #[command(subcommand)]
    Ref(RefVerb),
    /// Re-evaluate one pixel of a job and print what went into it
    Replay(ReplayArgs),
    /// List techniques, methods, scenes, maps or shipped configs
    List(ListArgs),
    /// Describe an entry of the registry: parameters, sources, known failures
    Explain(ExplainArgs),
    /// Print a completion script
    Completions { shell: clap_complete::Shell },
    /// Print the manual page
    Man,
}

#[derive(Debug, Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub selection: Selection,
    /// Do nothing but print the plan
    #[arg(long)]
    pub dry_run: bool,
    /// Stop at the first job that fails
    #[arg(long)]
    pub fail_fast: bool,
    /// Say nothing on stderr
    #[arg(short, long)]
    pub quiet: bool,
    /// Save a sequence at work every so many seconds, so that it goes on there after an interruption
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, value_parser = seconds)]
    pub checkpoint: f64,
    /// Print what each stage took, and how much of it one thread did alone
    #[arg(long)]
    pub profile: bool,
    /// Worker threads; default: all
    #[arg(short = 'j', long)]
    pub threads: Option<usize>,
}

/// Configs, overrides and filters, common to `run` and `plan`.
#[derive(Debug, Args)]
pub struct Selection {
    /// Config files, or shipped configs by name (`lightbench list configs`), and overrides: CONFIG… key=value…; a,b,c and from..to..step sweep
    #[arg(required = true, value_name = "CONFIG | key=value")]
    pub inputs: Vec<String>,
    /// Results folder; default: results/<name of the config>
    #[arg(short, long)]
    pub out: Option<PathBuf>,
    /// Only scenes that match
    #[arg(long, value_name = "GLOB")]
    pub scene: Option<String>,
    /// Only methods (labels) that match
    #[arg(long, value_name = "GLOB")]
    pub method: Option<String>,
    /// Run each contender with this many seeds
    #[arg(long)]
    pub repeats: Option<u32>,
    /// Do the K-th of N parts of the jobs (1 to N); those that share references stay together
    #[arg(long, value_name = "K/N")]
    pub shard: Option<String>,
}

#[derive(Debug, Args)]
pub struct PlanArgs {
    #[command(flatten)]
    pub selection: Selection,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Also say how much memory the caches will take, for which the geometry of the scenes is read
    #[arg(long)]
    pub memory: bool,
}

#[derive(Debug, Args)]
pub struct ReportArgs {
    /// A results folder, or its name below results/
    #[arg(value_parser = results_folder())]
    pub folder: PathBuf,
    /// Put all pictures into report.html, so that it can be sent alone
    #[arg(long)]
    pub single_file: bool,
}

#[derive(Debug, Args)]
pub struct GateArgs {
    /// A results folder, or its name below results/
    #[arg(value_parser = results_folder())]
    pub folder: PathBuf,
    /// Also write a JUnit XML file
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(after_help = DIFF_NOTES)]
pub struct DiffArgs {
    /// The results folder that is compared with, or its name below results/
    #[arg(value_parser = results_folder())]
    pub before: PathBuf,
    /// The results folder that is compared
    #[arg(value_parser = results_folder())]
    pub after: PathBuf,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Results folders of the same experiment
    #[arg(required = true, value_parser = results_folder())]
    pub folders: Vec<PathBuf>,
    /// The folder to write
    #[arg(short, long)]
    pub out: PathBuf,
}

/// One contender on one view, common to `render` and `caches`.
#[derive(Debug, Args)]
pub struct ContenderArgs {
    /// A shipped scene, NAME on LIGHTBENCH_SCENES, a scene.toml, a Mitsuba XML or a glTF file
    pub scene: String,
    /// A view of the scene; default: the first
    #[arg(long)]
    pub view: Option<String>,
    /// A camera path of the scene, in place of a view; of a stereo pair its left eye
    #[arg(long)]
    pub path: Option<String>,
    /// The moment that is shown, of scenes in which something moves
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub time: f64,
    /// What is computed: `lightbench list techniques`
    #[arg(long, default_value = "ambient-occlusion")]
    pub technique: String,
    /// A distribution such as VGC+DGS (the default), a sampler of environment maps such as
    /// decomposition (the default of environment-lighting), or `reference` for the exact function
    #[arg(long)]
    pub method: Option<String>,
    /// What the technique's methods share. Of cached light: records; default: 5.8 % of the pixels, the paper's 120K at
    /// full HD. Of environment lighting: shadow rays per shading point; default: 16. Of paths, direct light and radiance:
    /// samples a pixel; default: 1
    #[arg(long)]
    pub budget: Option<usize>,
    /// Pixels, for example 480x270; default: the view's
    #[arg(long, value_name = "WxH")]
    pub size: Option<String>,
    /// Samples per pixel
    #[arg(long, default_value_t = 1)]
    pub spp: u32,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Worker threads; default: all
    #[arg(short = 'j', long)]
    pub threads: Option<usize>,
    /// A parameter of the method or technique, or max_depth, environment, ao_distance,
    /// metres_per_unit of the scene
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
}

#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub contender: ContenderArgs,
    /// The image to write: .exr, or .png after exposure
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
    /// Print what it took as JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Args)]
pub struct CachesArgs {
    #[command(flatten)]
    pub contender: ContenderArgs,
    /// The CSV file to write
    #[arg(short, long, value_name = "FILE")]
    pub out: PathBuf,
}

#[derive(Debug, Args)]
pub struct LightsArgs {
    /// An embedded map, NAME on LIGHTBENCH_SCENES, or an .hdr or .exr file
    pub map: String,
    /// A sampler of environment maps
    #[arg(long, default_value = "decomposition")]
    pub method: String,
    /// Number of lights
    #[arg(long, default_value_t = 32)]
    pub budget: usize,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Draw them on the tone-mapped map, in a PNG file
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Worker threads; default: all
    #[arg(short = 'j', long)]
    pub threads: Option<usize>,
    /// A parameter of the method
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
}

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The image that is right: .exr, .hdr or .png
    pub reference: PathBuf,
    /// The image that is measured against it
    pub test: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Writes error and FLIP maps into this folder
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Exposure of linear images before they are clamped for display metrics, in stops
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// Pixels per degree of visual angle, for FLIP
    #[arg(long)]
    pub ppd: Option<f32>,
}

#[derive(Debug, Subcommand)]
pub enum SceneVerb {
    /// What is loaded, dropped, repaired, and what each technique needs
    Check(CheckArgs),
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// A shipped scene, NAME on LIGHTBENCH_SCENES, a scene.toml, a Mitsuba XML or a glTF file
    pub scene: String,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

#[derive(Debug, Subcommand)]
pub enum NewVerb {
    /// Write NAME.toml, an experiment that runs as it is
    Experiment {
        /// Letters, digits, - and _
        name: String,
    },
    /// Write NAME/scene.toml, a scene that renders as it is
    Scene {
        /// Letters, digits, - and _
        name: String,
    },
}

#[derive(Debug, Subcommand)]
pub enum RefVerb {
    /// The stored references and their noise floors
    Status(RefStatusArgs),
    /// Add samples to the references of a results folder, and render absent and damaged ones
    Extend(RefExtendArgs),
}

#[derive(Debug, Args)]
pub struct RefStatusArgs {
    /// The reference store
    #[arg(default_value = "results/references")]
    pub folder: PathBuf,
}

#[derive(Debug, Args)]
pub struct RefExtendArgs {
    /// A results folder, or its name below results/
    #[arg(value_parser = results_folder())]
    pub folder: PathBuf,
    /// Samples per pixel to reach; without it only absent and damaged references are rendered
    #[arg(long)]
    pub samples: Option<u32>,
}

#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// A job's folder, results/NAME/jobs/ID
    pub job: PathBuf,
    /// Column and row from the top left
    #[arg(long, value_name = "X,Y")]
    pub pixel: String,
}

#[derive(Debug, Args)]
pub struct ListArgs {
    /// techniques, distributions, refinements, interpolations, methods, samplers, scenes, maps or configs; default: all
    /// but configs
    pub kind: Option<String>,
}

#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// KIND/ID or ID, of composed methods such as VGC+DGS each part; `all` prints every page
    pub entry: String,
}

/// A number of seconds, 0 or more.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().ok();
    let seconds = seconds.filter(|s| (0.0..=1e9).contains(s));
    seconds.ok_or_else(|| "expected seconds, 0 or more".into())
}

/// A folder as it is named, or the one of this name below `results` where only that one holds a run.
fn results_folder() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().map(|named| {
        let below = Path::new("results").join(&named);
        match !named.join("plan.json").is_file() && below.join("plan.json").is_file() {
            true => below,
            false => named,
        }
    })
}
