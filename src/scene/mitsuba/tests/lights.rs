//! Emitters.

use super::*;

#[test]
fn emitters() {
    let scene = load(
        "0.5.0",
        "<shape type='cube'><emitter type='area'><rgb name='radiance' value='1 2 3'/></emitter></shape>
         <emitter type='directional'><vector name='direction' x='0' y='-2' z='0'/><rgb name='irradiance' value='4'/></emitter>
         <emitter type='sunsky'><vector name='sunDirection' x='0.88698' y='0.288862' z='0.360313'/><float name='turbidity' value='2'/><float name='skyScale' value='30'/><float name='sunScale' value='10'/></emitter>",
    );
    assert_eq!(scene.shapes[0].emission, Some([1.0, 2.0, 3.0]));
    let LightKind::Directional {
        direction,
        irradiance,
    } = &scene.lights[0].kind
    else {
        panic!("no parallel light");
    };
    assert_eq!((*direction, *irradiance), (DVec3::NEG_Y, [4.0; 3]));
    let Some(EnvironmentDescription::SunSky {
        sun: true,
        sky: true,
        scale,
        turbidity,
        sun_irradiance: Some([red, ..]),
        ..
    }) = scene.environment
    else {
        panic!("no sky");
    };
    assert_eq!((scale, turbidity), (30.0, 2.0));
    // A third of what it is beside a sky of the same factor.
    assert!((red * 3.0 - 1.34).abs() < 0.1, "{red}");
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let scene = load(
        "3.0.0",
        "<emitter type='envmap'><string name='filename' value='e.exr'/><float name='scale' value='2'/><transform name='to_world'><rotate y='1' angle='90'/></transform></emitter>",
    );
    let Some(EnvironmentDescription::Map {
        path,
        scale,
        to_world,
        rows: EnvironmentRows::PoleCentred,
    }) = scene.environment
    else {
        panic!("no map");
    };
    assert_eq!((path.as_path(), scale), (Path::new("dir/e.exr"), 2.0));
    assert!(to_world.transform_vector3(DVec3::Z).distance(DVec3::X) < 1e-12);
}

#[test]
fn suns_are_as_wide_as_they_are_declared() {
    let aperture = |version: &str, parameter: &str| {
        let sun = format!(
            "<emitter type='sunsky'><vector name='sun_direction' value='0 0.6 0.8'/>{parameter}</emitter>"
        );
        let scene = load(version, &sun);
        assert!(scene.notes.is_empty(), "{:?}", scene.notes);
        match scene.environment {
            Some(EnvironmentDescription::SunSky {
                sun_aperture_deg, ..
            }) => sun_aperture_deg,
            _ => panic!("no sky"),
        }
    };
    let of = |name: &str, value: f64| format!("<float name='{name}' value='{value}'/>");
    assert_eq!(aperture("3.0.0", ""), None);
    assert_eq!(aperture("3.0.0", &of("sun_aperture", 5.0)), Some(5.0));
    let scaled = aperture("0.5.0", &of("sunRadiusScale", 10.0));
    assert!(scaled.is_some_and(|degrees| (degrees - 5.358).abs() < 1e-9));
}

#[test]
fn a_weight_of_0_is_told() {
    let emitter = |weight: &str| {
        load(
            "3.0.0",
            &format!(
                "<emitter type='point'><float name='sampling_weight' value='{weight}'/></emitter>"
            ),
        )
        .notes
    };
    assert!(emitter("0")[0].contains("sampling_weight of 0"));
    assert!(emitter("0.5").is_empty());
}

#[test]
fn lamps_shine_by_spectra_that_are_plugins() {
    let scene = load(
        "3.0.0",
        "<shape type='cube'><emitter type='area'><spectrum name='radiance' type='uniform'>\
         <float name='value' value='3'/></spectrum></emitter></shape>",
    );
    assert_eq!(scene.shapes[0].emission, Some([3.0; 3]));
}

/// A spectrum may be written as a texture: it shines all the same.
#[test]
fn lamps_shine_by_spectra_that_are_called_textures() {
    let emission = |tag: &str, values: &str| {
        let lamp = format!(
            "<shape type='cube'><emitter type='area'><{tag} name='radiance' type='irregular'>\
             <string name='wavelengths' value='400,700'/><string name='values' value='{values}'/>\
             </{tag}></emitter></shape>"
        );
        load("3.0.0", &lamp).shapes[0].emission
    };
    let shining = emission("texture", "5,5");
    assert_eq!(shining, emission("spectrum", "5,5"));
    assert!(shining.is_some_and(|rgb| rgb.iter().all(|c| *c > 3.0)));
}

#[test]
fn no_light_takes_light_away() {
    for (xml, expected) in [
        (
            "<shape type='cube'><emitter type='area'><rgb name='radiance' value='1 -1 1'/></emitter></shape>",
            "the radiance of a light must be finite and not below 0",
        ),
        (
            "<emitter type='constant'><rgb name='radiance' value='-1'/></emitter>",
            "the radiance of a light must be finite and not below 0",
        ),
        (
            "<emitter type='envmap'><string name='filename' value='a.exr'/><float name='scale' value='-2'/></emitter>",
            "the scale of a map is -2: below 0",
        ),
    ] {
        let message = error(&format!("{SENSOR}\n{xml}"));
        assert!(message.starts_with("dir/s.xml:2:"), "{message}");
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn an_area_light_may_stand_by_itself() {
    let lamp = "<emitter type='area' id='e'><rgb name='radiance' value='2'/></emitter>";
    let used = load(
        "3.0.0",
        &format!("{lamp}<shape type='cube'><ref id='e'/></shape>"),
    );
    assert!(used.notes.is_empty(), "{:?}", used.notes);
    assert_eq!(used.shapes[0].emission, Some([2.0; 3]));
    let notes = load("3.0.0", &format!("{lamp}<shape type='cube'/>")).notes;
    assert_eq!(notes, ["emitter `area` that nothing refers to is left out"]);
}
