//! What is kept of a vertex in its layer, a plane for each number.

/// Numbers that are kept of each pixel and layer; of colours the first of three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plane {
    /// 1 where a vertex is on a surface.
    Surface,
    /// Weight of `E` for others: 0 in holes and without a base.
    Base,
    /// Weight of `G` for others: 0 without gloss.
    Gloss,
    /// 1 where `E` is a guess of coarser cells, to be filled from neighbours.
    Hole,
    NormalX,
    NormalY,
    NormalZ,
    /// Length of the leg to the next vertex, scene units.
    Segment,
    /// Length of the path to here, scene units.
    PathLength,
    Lightness,
    GreenRed,
    BlueYellow,
    /// Factor on differences of colour.
    ColourScale,
    /// Luminance of `E + G`, exposed.
    Luminance,
    E,
    G = Plane::E as isize + 3,
    Emission = Plane::G as isize + 3,
    Albedo = Plane::Emission as isize + 3,
    Throughput = Plane::Albedo as isize + 3,
}

/// Planes of a layer.
pub(super) const PLANES: usize = Plane::Throughput as usize + 3;
