//! The elements, plugins and parameters that Mitsuba's documentation knows (versions 0.5, 0.6 and 3), whether we model
//! them or not: what is not among them is a slip of the finger, which Mitsuba refuses as well.

use std::collections::HashMap;
use std::sync::LazyLock;

use super::element::Element;
use crate::scene::SceneError;
use crate::scene::text::{advice, nearest};

/// `tag plugin …: parameters`. Parameters of version 0.x are in `snake_case`, as [`Element`] has them. `*` stands for any
/// name: of plugins that name what is in them freely, or that leave no trace in what we import.
const PLUGINS: &str = "
bsdf diffuse: reflectance diffuse_reflectance
bsdf roughdiffuse: reflectance diffuse_reflectance alpha use_fast_approx
bsdf dielectric thindielectric: int_ior ext_ior specular_reflectance specular_transmittance
bsdf roughdielectric: int_ior ext_ior specular_reflectance specular_transmittance distribution alpha alpha_u alpha_v sample_visible
bsdf conductor: material eta k ext_eta specular_reflectance
bsdf roughconductor: material eta k ext_eta specular_reflectance distribution alpha alpha_u alpha_v sample_visible
bsdf plastic: int_ior ext_ior diffuse_reflectance specular_reflectance nonlinear
bsdf roughplastic: int_ior ext_ior diffuse_reflectance specular_reflectance nonlinear distribution alpha sample_visible
bsdf pplastic: int_ior ext_ior diffuse_reflectance specular_reflectance distribution alpha alpha_u alpha_v sample_visible
bsdf phong: exponent diffuse_reflectance specular_reflectance
bsdf ward: variant alpha_u alpha_v diffuse_reflectance specular_reflectance
bsdf principled: base_color roughness anisotropic metallic spec_trans eta specular spec_tint sheen sheen_tint flatness clearcoat clearcoat_gloss diffuse_reflectance_sampling_rate main_specular_sampling_rate clearcoat_sampling_rate
bsdf principledthin: base_color roughness anisotropic spec_trans eta spec_tint sheen sheen_tint flatness diff_trans diffuse_reflectance_sampling_rate diffuse_transmittance_sampling_rate specular_reflectance_sampling_rate specular_transmittance_sampling_rate
bsdf coating: int_ior ext_ior thickness sigma_a specular_reflectance specular_transmittance
bsdf roughcoating: int_ior ext_ior thickness sigma_a specular_reflectance specular_transmittance distribution alpha sample_visible
bsdf hair: int_ior ext_ior eumelanin pheomelanin sigma_a scale longitudinal_roughness azimuthal_roughness scale_tilt
bsdf hk: material sigma_s sigma_a sigma_t albedo thickness
bsdf difftrans: transmittance
bsdf measured: filename
bsdf measured_polarized: filename alpha_sample wavelength
bsdf circular: theta transmittance left_handed
bsdf polarizer: theta transmittance polarizing
bsdf retarder: theta delta transmittance
bsdf twosided null:
bsdf mask: opacity
bsdf blendbsdf: weight
bsdf mixturebsdf: weights ensure_energy_conservation
bsdf bumpmap normalmap irawan: *
texture bitmap: filename bitmap data filter_type wrap_mode wrap_mode_u wrap_mode_v raw to_uv accel format gamma cache max_anisotropy channel uscale vscale uoffset voffset
texture checkerboard: color0 color1 to_uv uscale vscale uoffset voffset
texture gridtexture: color0 color1 line_width uscale vscale uoffset voffset
texture mesh_attribute: name scale
texture vertexcolors:
texture wireframe: interior_color edge_color line_width step_width
texture curvature: curvature scale
texture scale: *
texture volume volume_adapter: *
texture uniform: value lambda_min lambda_max wavelength_min wavelength_max
texture regular: values lambda_min lambda_max wavelength_min wavelength_max
texture irregular discrete: values wavelengths
texture srgb: color
texture rgb: color value
texture d65: color scale
texture blackbody: temperature lambda_min lambda_max wavelength_min wavelength_max
texture rawconstant: value
emitter area: radiance sampling_weight
emitter constant: radiance sampling_weight
emitter envmap: filename bitmap scale to_world gamma cache mis_compensation sampling_weight
emitter point: position to_world intensity sampling_weight
emitter spot: intensity cutoff_angle beam_width texture to_world sampling_weight
emitter directional: direction to_world irradiance sampling_weight
emitter directionalarea: radiance to_world sampling_weight
emitter collimated: power to_world sampling_weight
emitter projector: irradiance scale to_world fov fov_axis principal_point_offset_x principal_point_offset_y sampling_weight
emitter sun sky sunsky: turbidity albedo latitude longitude timezone year month day hour minute second sun_direction scale sun_scale sky_scale sun_aperture sun_radius_scale complex_sun stretch resolution extend to_world sampling_weight
emitter timed_sunsky: *
shape obj: filename shape_name shape_index collapse face_normals flip_tex_coords flip_normals max_smooth_angle to_world
shape ply: filename srgb face_normals flip_tex_coords flip_normals max_smooth_angle to_world
shape serialized: filename shape_index face_normals flip_normals max_smooth_angle to_world
shape sphere: center radius flip_normals to_world
shape cylinder: p0 p1 radius flip_normals to_world
shape rectangle cube disk: flip_normals to_world
shape instance shapegroup merge: to_world
shape hair: filename radius angle_threshold reduction to_world
shape bsplinecurve linearcurve: filename silhouette_sampling to_world
shape heightfield: filename width height scale shading_normals flip_normals to_world
shape sdfgrid: filename grid normals watertight to_world
shape blender ellipsoids ellipsoidsmesh deformable: *
sensor perspective: fov fov_axis focal_length near_clip far_clip focus_distance principal_point_offset_x principal_point_offset_y shift_x shift_y shutter_open shutter_close to_world srf
sensor thinlens: aperture_radius fov fov_axis focal_length near_clip far_clip focus_distance principal_point_offset_x principal_point_offset_y shutter_open shutter_close to_world srf
sensor perspective_rdist: kc fov fov_axis focal_length near_clip far_clip focus_distance shutter_open shutter_close to_world
sensor orthographic telecentric spherical radiancemeter irradiancemeter fluencemeter distant batch: *
film hdrfilm: width height crop_offset_x crop_offset_y crop_width crop_height sample_border high_quality_edges banner file_format pixel_format component_format compensate attach_log channel_names
film ldrfilm: width height crop_offset_x crop_offset_y crop_width crop_height sample_border high_quality_edges banner file_format pixel_format tonemap_method gamma exposure key burn
film specfilm tiledhdrfilm mfilm: *
sampler independent stratified multijitter orthogonal ldsampler halton hammersley sobol: sample_count seed dimension jitter strength scramble
rfilter box tent gaussian mitchell catmullrom lanczos: radius stddev lobes a b c
integrator path volpath volpathmis volpath_simple: max_depth rr_depth hide_emitters strict_normals samples_per_pass block_size timeout
integrator direct: shading_samples emitter_samples bsdf_samples luminaire_samples hide_emitters strict_normals samples_per_pass block_size timeout
integrator aov depth moment stokes ptracer prb prb_basic prbvolpath prb_projective direct_projective direct_reparam prb_reparam emission_reparam ad_threepoint multichannel field motion ao bdpt pssmlt mlt erpt photonmapper ppm sppm vpl irrcache adaptive: *
medium homogeneous heterogeneous: *
volume constvolume gridvolume volcache hgridvolume: *
phase isotropic hg tabphase rayleigh sggx kkay microflake mixturephase blendphase: *
subsurface dipole singlescatter: *
";

/// Attributes of elements that are no plugins.
const ATTRIBUTES: &[(&str, &str)] = &[
    ("default", "name value"),
    ("include", "filename"),
    ("path", "value"),
    ("alias", "id as"),
    ("ref", "id name"),
    ("float", "name value"),
    ("integer", "name value"),
    ("boolean", "name value"),
    ("string", "name value"),
    ("rgb", "name value intent unit"),
    ("srgb", "name value intent unit"),
    ("color", "name value"),
    ("spectrum", "name value filename intent unit type scale id"),
    ("blackbody", "name value temperature scale"),
    ("point", "name value x y z"),
    ("vector", "name value x y z"),
    ("transform", "name time type"),
    ("animation", "name"),
    ("translate", "value x y z"),
    ("scale", "value x y z"),
    ("rotate", "value x y z angle"),
    ("matrix", "value"),
    ("lookat", "origin target up"),
    ("scene", "version type id"),
];

/// Older names of the tags of plugins.
const SAME_TAG: [(&str, &str); 2] = [("camera", "sensor"), ("luminaire", "emitter")];

/// Parameters of each plugin, by tag and type.
static KNOWN: LazyLock<HashMap<(&str, &str), Vec<&str>>> = LazyLock::new(|| {
    let mut known = HashMap::new();
    for line in PLUGINS.lines() {
        let Some((plugins, parameters)) = line.split_once(':') else {
            continue;
        };
        let mut words = plugins.split_whitespace();
        let tag = words.next().unwrap_or("");
        for plugin in words {
            known.insert((tag, plugin), parameters.split_whitespace().collect());
        }
    }
    known
});

/// Refuses elements, attributes, plugins and parameters that Mitsuba does not know; `target` gives what a `<ref>` refers
/// to.
pub(super) fn check<'a>(
    element: &'a Element,
    target: &impl Fn(&'a Element) -> Option<&'a Element>,
) -> Result<(), SceneError> {
    check_attributes(element)?;
    let tag = plugin_tag(&element.tag);
    if TAGS.contains(&tag) && !element.kind().is_empty() {
        check_plugin(element, tag, target)?;
    }
    element.children.iter().try_for_each(|c| check(c, target))
}

fn plugin_tag(tag: &str) -> &str {
    let newer = SAME_TAG.iter().find(|(older, _)| *older == tag);
    newer.map_or(tag, |(_, newer)| newer)
}

/// The tags of plugins.
static TAGS: LazyLock<Vec<&str>> = LazyLock::new(|| {
    let mut tags: Vec<&str> = KNOWN.keys().map(|(tag, _)| *tag).collect();
    tags.sort_unstable();
    tags.dedup();
    tags
});

fn check_attributes(element: &Element) -> Result<(), SceneError> {
    let tag = element.tag.as_str();
    let known = match ATTRIBUTES.iter().find(|(name, _)| *name == tag) {
        Some((_, known)) => *known,
        None if TAGS.contains(&plugin_tag(tag)) => "type name id version",
        None => {
            let mut known = TAGS.clone();
            known.extend(ATTRIBUTES.iter().map(|(name, _)| name));
            let advice = advice(tag, &known);
            return Err(element.error(format!("unknown element <{tag}>; {advice}")));
        }
    };
    let known: Vec<&str> = known.split_whitespace().collect();
    match element.attribute_names().find(|name| !known.contains(name)) {
        None => Ok(()),
        Some(name) => {
            let advice = advice(name, &known);
            Err(element.error(format!("unknown attribute `{name}` of <{tag}>; {advice}")))
        }
    }
}

fn check_plugin<'a>(
    element: &'a Element,
    tag: &str,
    target: &impl Fn(&'a Element) -> Option<&'a Element>,
) -> Result<(), SceneError> {
    let kind = element.kind();
    let Some(known) = KNOWN.get(&(tag, kind)) else {
        let plugins = KNOWN.keys().filter(|(of, _)| *of == tag);
        let mut plugins: Vec<&str> = plugins.map(|(_, plugin)| *plugin).collect();
        plugins.sort_unstable();
        // Integrators of others say how, not what is rendered: published scenes name some.
        if tag == "integrator" && nearest(kind, &plugins).is_none() {
            return Ok(());
        }
        let advice = advice(kind, &plugins);
        return Err(element.error(format!("unknown {tag} `{kind}`; {advice}")));
    };
    if known.contains(&"*") {
        return Ok(());
    }
    for child in element.children.iter().filter(|c| !c.name().is_empty()) {
        let name = child.name();
        if known.contains(&name) || is_free(child, tag, target) {
            continue;
        }
        let advice = match known.is_empty() {
            true => "it has none".to_owned(),
            false => advice(name, known),
        };
        let message = format!("unknown parameter `{name}` of {tag} `{kind}`; {advice}");
        return Err(child.error(message));
    }
    Ok(())
}

/// Whether the name of a child means nothing: of objects in objects their kind counts, but of textures their name;
/// attributes of meshes and texts in pictures are named by those who use them.
fn is_free<'a>(
    child: &'a Element,
    parent: &str,
    target: &impl Fn(&'a Element) -> Option<&'a Element>,
) -> bool {
    let freely_named: &[&str] = match parent {
        "shape" => &["vertex_", "face_"],
        "film" => &["label[", "metadata["],
        _ => &[],
    };
    if freely_named
        .iter()
        .any(|start| child.name().starts_with(start))
    {
        return true;
    }
    let is_object = |tag: &str| tag != "texture" && TAGS.contains(&plugin_tag(tag));
    match child.tag.as_str() {
        // One that refers to nothing is refused where it is used.
        "ref" => target(child).is_none_or(|of| is_object(&of.tag)),
        tag => is_object(tag),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::import;
    use super::super::parse::parse_document;

    fn load(text: &str) -> Result<Vec<String>, String> {
        let text = format!("<scene version='3.0.0'><sensor type='perspective'/>\n{text}</scene>");
        let document = parse_document(Path::new("s.xml"), &text).expect("XML");
        let scene = import(&document, Path::new("s.xml"), "s").map_err(|e| e.to_string())?;
        Ok(scene.notes)
    }

    #[test]
    fn what_mitsuba_does_not_know_is_refused_with_a_suggestion() {
        for (text, expected) in [
            (
                "<shape type='sphere'><float name='raduis' value='0.3'/></shape>",
                "unknown parameter `raduis` of shape `sphere`; did you mean `radius`",
            ),
            (
                "<sensor type='perspective'><film type='hdrfilm'><integer name='widht' value='16'/></film></sensor>",
                "unknown parameter `widht` of film `hdrfilm`; did you mean `width`",
            ),
            (
                "<integrator type='paht'/>",
                "unknown integrator `paht`; did you mean `path`",
            ),
            (
                "<shape type='shpere'/>",
                "unknown shape `shpere`; did you mean `sphere`",
            ),
            (
                "<bsdf type='difuse' id='nobody_uses_it'/>",
                "unknown bsdf `difuse`; did you mean `diffuse`",
            ),
            (
                "<shpae type='sphere'/>",
                "unknown element <shpae>; did you mean `shape`",
            ),
            (
                "<shape type='sphere'><float nmae='radius' value='1'/></shape>",
                "unknown attribute `nmae` of <float>; did you mean `name`",
            ),
            (
                "<bsdf type='diffuse'><texture name='reflectanse' type='bitmap'><string name='filename' value='a.png'/></texture></bsdf>",
                "unknown parameter `reflectanse`",
            ),
            (
                "<texture type='checkerboard' id='t'/><bsdf type='diffuse'><ref name='reflectanse' id='t'/></bsdf>",
                "unknown parameter `reflectanse`",
            ),
            (
                "<bsdf type='twosided'><float name='alpha' value='1'/></bsdf>",
                "unknown parameter `alpha` of bsdf `twosided`; it has none",
            ),
        ] {
            let error = load(text).expect_err(text);
            assert!(error.starts_with("s.xml:2:"), "{error}");
            assert!(error.contains(expected), "{error} ({expected})");
        }
    }

    #[test]
    fn what_mitsuba_knows_is_read_or_noted() {
        let notes = load(
            "<default name='never_used' value='1'/>
             <sensor type='perspective'><film type='hdrfilm'><string name='label[10, 10]' value='a'/><integer name='cropOffsetX' value='0'/></film></sensor>
             <shape type='sphere'><bsdf type='diffuse' name='any name'/><emitter name='lamp' type='area'/></shape>
             <shape type='ply'><string name='filename' value='gone.ply'/><texture type='bitmap' name='vertex_tint'><string name='filename' value='a.png'/></texture></shape>
             <bsdf type='bumpmap' id='b'><texture name='map' type='bitmap'><string name='filename' value='a.png'/></texture><bsdf type='diffuse'/></bsdf>
             <integrator type='path_guiding_integrator'/>
             <emitter type='projector'><float name='fov' value='20'/></emitter>",
        )
        .expect("reads");
        assert!(
            notes
                .iter()
                .any(|n| n.contains("emitter `projector` is left out")),
            "{notes:?}"
        );
    }
}
