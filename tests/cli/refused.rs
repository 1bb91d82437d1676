//! Configs, overrides and selections that are refused: exit codes and messages.

use super::{Place, TIMED, TINY};

#[test]
fn wrong_configs_are_refused_with_their_place_and_nothing_is_written() {
    let cases = [
        ("name = \"x\"\ntechnique = ", "bad.toml:2:"),
        (
            &TINY.replace("caches = 60", "cashes = 60"),
            "bad.toml:5:1: unknown field `cashes`",
        ),
        (&TINY.replace("ambient-occlusion", "ambient"), "bad.toml:3:"),
        (
            &TINY.replace("hard-cases", "no-such-scene"),
            "no-such-scene",
        ),
        (
            &TINY.replace("id = \"IM\"", "id = \"XY\""),
            "no distribution is called `XY`",
        ),
        (
            &TINY.replace("id = \"IM\"", "id = \"IM\"\nsigma = 3"),
            "bad.toml:15:1: unknown parameter `sigma`",
        ),
        (
            &TINY.replace("view = \"poles\"", "view = \"attic\""),
            "it has: poles",
        ),
        (
            &TINY.replace("side = 8", "side = 0"),
            "side = 0: expected a whole number from 1 to 256",
        ),
        (
            &TINY.replace("side = 8", "side = 8, distance = inf"),
            "distance: expected finite numbers, found inf",
        ),
        (&TINY.replace("rmse(IM)", "rmse(IM"), "expected `)`"),
        (
            &format!(
                "{TINY}[[figure]]\nname = \"f\"\nkind = \"side-by-side\"\nscenes = [\"hard-case\"]\n"
            ),
            "no scene is called `hard-case`",
        ),
        (
            &format!(
                "{TINY}[[figure]]\nname = \"f\"\nkind = \"side-by-side\"\ninsets = [[0.8, 0, 0.3, 0.1]]\n"
            ),
            "lies within it, found [0.8, 0.0, 0.3, 0.1]",
        ),
        (
            &TINY.replace("< rmse(IM)", "< rmse(XX)"),
            "no method is called `XX`",
        ),
        (
            &TINY.replace("rmse(VGC+DGS) < 0.5", "rmsx(VGC+DGS) < 0.5"),
            "rmsx",
        ),
        (
            &TINY.replace("\"tiny\"", "\"../../tiny\""),
            "bad.toml:2:1: name: expected the name of one folder",
        ),
        (
            &TINY.replace("[48, 27]", "[48, 27, 3]"),
            "bad.toml:6:8: expected 2 values, found 3",
        ),
        (
            &format!("{TINY}[sweep]\ncaches = []\n"),
            "`caches` is swept over no value",
        ),
        (
            &format!("{TINY}[sweep]\ntechnique = [\"ambient-occlusion\", \"path-tracing\"]\n"),
            "an experiment has one `technique`",
        ),
        (
            &TINY.replace("repeats = 2", "repeats = 2\nenvironment = \"afternoon\""),
            "bad.toml:8:1: ambient-occlusion takes no `environment`",
        ),
        (&TINY.replace("\"tiny\"", "\"..\""), "bad.toml:2:1: name"),
        (&TINY.replace("\"tiny\"", "\"\""), "bad.toml:2:1: name"),
        (
            &TINY.replace("\"errors\"", "\"a/errors\""),
            "name: expected the name of one folder",
        ),
        (
            &TINY.replace("repeats = 2", "repeats = 4000000000"),
            "make 8000000000 jobs; 1000000 at most",
        ),
    ];
    for (text, expected) in cases {
        let place = Place::new();
        place.write("bad.toml", text);
        let output = place.lightbench(&["run", "bad.toml"]);
        assert_eq!(output.code, 2, "{expected}: {}", output.err);
        assert!(
            output.err.contains(expected),
            "expected `{expected}` in: {}",
            output.err
        );
        assert!(!place.path().join("results").exists(), "{expected}");
    }
}

#[test]
fn wrong_budgets_are_refused_with_their_key_and_what_is_expected() {
    let place = Place::new();
    let scene = "name = \"still-puzzle\"";
    let number = "seconds: expected a number above 0 and up to 86400";
    for (text, expected) in [
        (TIMED.replace("0.02", "0"), number),
        (TIMED.replace("0.02", "-1.5"), number),
        (
            TIMED.replace("0.02", "inf"),
            "seconds: expected finite numbers, found inf",
        ),
        (TIMED.replace("0.02", "\"long\""), "bad.toml:5:"),
        (
            TIMED.replace("0.02", "0.02\nlights = 4"),
            "two budgets, `lights` and `seconds`: expected one of them",
        ),
        (
            TIMED.replace(scene, &format!("{scene}\nlights = 4")),
            "two budgets",
        ),
        (
            TIMED.replace("seconds = 0.02", "caches = 4"),
            "takes `lights`, `seconds` or `rays_per_pixel`, not `caches`",
        ),
        (
            TINY.replace("caches = 60", "seconds = 1.0"),
            "takes `caches`, not `seconds`",
        ),
        (TIMED.replace("seconds = 0.02", ""), "set `lights`"),
    ] {
        place.write("bad.toml", &text);
        let output = place.lightbench(&["plan", "bad.toml"]);
        assert_eq!(output.code, 2, "{expected}: {}", output.err);
        assert!(output.err.contains(expected), "{expected}: {}", output.err);
    }
}

#[test]
fn wrong_overrides_and_selections_are_refused() {
    let place = Place::new();
    place.write("tiny.toml", TINY);
    let sized = TINY.replace("view = \"poles\"", "view = \"poles\"\nsize = [48, 27]");
    place.write("sized.toml", &sized);
    let set = ["--set", "side=8", "--set", "side=9"];
    let twice = ["render", "hard-cases", "--out", "x.exr"]
        .into_iter()
        .chain(set);
    for (arguments, code, expected) in [
        (twice.collect(), 2, "--set side=9: `side` is set twice"),
        (
            vec!["run", "sized.toml", "size=[24, 14]"],
            2,
            "every scene of the config has `size` of its own: write scene.*.size=…",
        ),
        (
            vec!["run", "tiny.toml", "--method", "["],
            2,
            "--method [: no pattern of names",
        ),
        (
            vec![
                "lights",
                "studio",
                "--method",
                "median-cut",
                "--budget",
                "4",
                "--out",
                "x.exr",
            ],
            2,
            "--out x.exr: expected a .png file",
        ),
        (
            vec!["compare", "a.exr", "b.exr", "--out", "tiny.toml"],
            2,
            "--out tiny.toml: expected a folder",
        ),
        (vec!["run", "tiny.toml", "caches=many"], 2, "caches"),
        (
            vec!["run", "tiny.toml", "method.XX.a=1"],
            2,
            "no method is called `XX`",
        ),
        (vec!["run", "tiny.toml", "--shard", "3/2"], 2, "K/N"),
        (vec!["run", "absent.toml"], 2, "absent.toml"),
        (
            vec!["run", "tiny.toml", "--scene", "moon*"],
            3,
            "scenes are ",
        ),
        (
            vec!["render", "hard-cases", "--out", "x.gif"],
            2,
            ".exr or .png",
        ),
        (vec!["render", "nowhere", "--out", "x.exr"], 2, "nowhere"),
        (
            vec![
                "render",
                "hard-cases",
                "--method",
                "reference",
                "--set",
                "sid=8",
                "--out",
                "x.exr",
            ],
            2,
            "no such parameter",
        ),
        (vec!["report", "."], 2, "plan.json"),
        (vec!["explain", "distributions/XX"], 2, "no entry"),
        (vec!["explain", "VGC+XX"], 2, "no entry"),
    ] {
        let output = place.lightbench(&arguments);
        assert_eq!(output.code, code, "{arguments:?}: {}", output.err);
        assert!(
            output.err.contains(expected),
            "{arguments:?}: {}",
            output.err
        );
    }
    assert!(!place.path().join("results").exists());
}
