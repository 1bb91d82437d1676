//! Statues as blended implicit bodies, facing +z, standing on y = 0.

use glam::{Vec2, Vec3};

use super::kit::field::{ball, blend, block, carve, drum, ellipsoid, fold, limb, ramp, ring};
use super::kit::polygonise;
use crate::scene::Mesh;

/// A robed figure seated with crossed legs on a lotus, 1.5 m high, 1.2 m wide.
pub fn seated(cell: f32) -> Mesh {
    polygonise([[-0.75, -0.06, -0.75], [0.75, 1.6, 0.75]], cell, |p| {
        let q = Vec3::new(p.x.abs(), p.y, p.z);
        let lotus = lotus(p);
        // Far from the figure its bounding ball is distance enough.
        let around = ball(p, [0.0, 0.9, 0.0], 0.85);
        if around > 0.2 {
            return lotus.min(around);
        }
        let body = seated_body(p, q);
        let whole = blend(body, seated_head(q), 0.03).min(halo(p));
        blend(lotus, whole, 0.05)
    })
}

fn seated_body(p: Vec3, q: Vec3) -> f32 {
    let thigh = limb(q, [0.1, 0.38, -0.05], [0.45, 0.38, 0.14], [0.14, 0.11]);
    let shin = limb(q, [0.45, 0.37, 0.16], [-0.06, 0.35, 0.36], [0.1, 0.065]);
    let legs = blend(thigh, shin, 0.06);
    let waist = limb(q, [0.0, 0.42, -0.04], [0.0, 0.8, -0.04], [0.21, 0.17]);
    let chest = ellipsoid(q, [0.08, 0.82, 0.0], [0.17, 0.14, 0.14]);
    let shoulder = ball(q, [0.22, 0.87, -0.03], 0.085);
    let torso = blend(blend(waist, chest, 0.1), shoulder, 0.08);
    let upper_arm = limb(q, [0.24, 0.87, -0.03], [0.34, 0.58, 0.0], [0.08, 0.065]);
    let forearm = limb(q, [0.34, 0.58, 0.0], [0.1, 0.465, 0.27], [0.065, 0.042]);
    let arms = blend(upper_arm, forearm, 0.03);
    // Robe: folds run diagonally over the chest, along the sleeves and around the knees.
    let slope = (p.y - 0.55) * 1.0 - p.x * 0.75 + 0.35 * p.z;
    let over_chest = fold(slope * 62.0 + 1.6 * (p.x * 9.0).sin());
    let bare = ramp(p.y + 0.9 * p.x, 0.86, 0.8);
    let torso = torso - 0.007 * over_chest * bare * ramp(p.y, 0.38, 0.46);
    let sleeve = fold(((q.y - 0.55) + (q.z - q.x) * 0.6) * 70.0);
    let arms = arms - 0.006 * sleeve * ramp(q.z, 0.2, 0.12);
    let around_knee = fold(Vec2::new(q.x - 0.1, (q.z + 0.05) * 0.8).length() * 75.0 + q.y * 18.0);
    let legs = legs - 0.007 * around_knee;
    let skirt = skirt(p);
    let hand = ellipsoid(q, [0.05, 0.455, 0.29], [0.095, 0.028, 0.06]);
    let thumb = limb(q, [0.09, 0.48, 0.28], [0.015, 0.515, 0.3], [0.018, 0.013]);
    let robe = blend(blend(legs, torso, 0.09), skirt, 0.03);
    blend(blend(robe, arms, 0.035), hand.min(thumb), 0.012) * 0.85
}

/// Pleats that fan out between the shins over the lotus.
fn skirt(p: Vec3) -> f32 {
    let below = p.y - 0.38;
    if below > 0.1 {
        return below;
    }
    let angle_rad = p.x.atan2(p.z + 0.25);
    let pleats = 0.008 * fold(angle_rad * 34.0);
    ellipsoid(p, [0.0, 0.315, 0.22], [0.36, 0.045, 0.27]) - pleats
}

fn seated_head(q: Vec3) -> f32 {
    let neck = limb(q, [0.0, 0.9, -0.01], [0.0, 1.04, 0.0], [0.07, 0.055]);
    let rings = 0.003 * fold(q.y * 130.0) * ramp(q.y, 0.93, 0.96) * ramp(q.y, 1.03, 1.01);
    blend(neck - rings, head(q, [0.0, 1.14, 0.015], true), 0.03)
}

/// A head 0.3 m high about `centre`; with `curls` it wears snail curls and long ear lobes.
fn head(q: Vec3, centre: [f32; 3], curls: bool) -> f32 {
    let p = q - Vec3::from(centre);
    let apart = p.length() - 0.24;
    if apart > 0.1 {
        return apart;
    }
    let skull = ellipsoid(p, [0.0, 0.02, -0.01], [0.102, 0.125, 0.118]);
    let jaw = ellipsoid(p, [0.0, -0.065, 0.025], [0.074, 0.07, 0.083]);
    let mut face = blend(skull, jaw, 0.06);
    face = carve(
        face,
        ellipsoid(p, [0.042, 0.012, 0.125], [0.03, 0.016, 0.03]),
        0.015,
    );
    face = blend(
        face,
        ellipsoid(p, [0.041, 0.007, 0.088], [0.024, 0.012, 0.016]),
        0.008,
    );
    let brow = limb(
        p,
        [0.012, 0.03, 0.112],
        [0.07, 0.034, 0.085],
        [0.007, 0.005],
    );
    face = blend(face, brow, 0.012);
    let nose = limb(p, [0.0, 0.02, 0.108], [0.0, -0.037, 0.126], [0.009, 0.014]);
    let wing = ball(p, [0.013, -0.04, 0.114], 0.01);
    face = blend(face, nose.min(wing), 0.012);
    let lips = limb(
        p,
        [0.0, -0.069, 0.107],
        [0.028, -0.066, 0.096],
        [0.008, 0.004],
    );
    let lower_lip = limb(
        p,
        [0.0, -0.083, 0.103],
        [0.018, -0.081, 0.097],
        [0.008, 0.005],
    );
    face = blend(face, lips.min(lower_lip), 0.006);
    if !curls {
        let ear = ellipsoid(p, [0.104, 0.0, -0.01], [0.013, 0.036, 0.024]);
        return blend(face, ear, 0.01);
    }
    let ear = ellipsoid(p, [0.108, -0.025, -0.01], [0.014, 0.068, 0.025]);
    let hollow = ellipsoid(p, [0.122, -0.01, -0.002], [0.012, 0.035, 0.013]);
    let ear = carve(ear, hollow, 0.008);
    let spin = p * 105.0;
    let bumps = 0.0075 * spin.x.sin() * spin.y.sin() * spin.z.sin();
    let cap = ellipsoid(p, [0.0, 0.055, -0.022], [0.115, 0.11, 0.122]);
    let bun = ball(p, [0.0, 0.165, -0.03], 0.055);
    let hair = blend(cap, bun, 0.03) - bumps;
    blend(face, ear, 0.012).min(hair)
}

/// A carved disc behind the head: rays, beads and a rim.
fn halo(p: Vec3) -> f32 {
    let q = p - Vec3::new(0.0, 1.12, -0.2);
    let away = q.z.abs() - 0.05;
    if away > 0.1 {
        return away;
    }
    let radius = Vec2::new(q.x, q.y).length();
    let angle_rad = q.x.atan2(q.y);
    let rays = 0.006 * fold(angle_rad * 24.0) * ramp(radius, 0.15, 0.17) * ramp(radius, 0.27, 0.25);
    let upright = Vec3::new(q.x, q.z, q.y);
    let disc = drum(upright, [0.0; 3], [0.335, 0.016], 0.006) - rays;
    let rim = ring(upright, [0.0, 0.01, 0.0], 0.325, 0.02);
    let turn = std::f32::consts::TAU / 36.0;
    let nearest = (angle_rad / turn).round() * turn;
    let bead_at = Vec2::new(nearest.sin(), nearest.cos()) * 0.287;
    let bead = ball(q, [bead_at.x, bead_at.y, 0.014], 0.015);
    blend(blend(disc, rim, 0.01), bead, 0.004) * 0.85
}

/// Two rows of petals on a stepped foot.
fn lotus(p: Vec3) -> f32 {
    let radius = Vec2::new(p.x, p.z).length();
    let outside = (radius - 0.72).max(p.y - 0.4);
    if outside > 0.1 {
        return outside;
    }
    let angle_rad = p.x.atan2(p.z);
    let seat = drum(p, [0.0, 0.25, 0.0], [0.55, 0.04], 0.02);
    let core = drum(p, [0.0, 0.15, 0.0], [0.47, 0.15], 0.03);
    let foot = drum(p, [0.0, 0.02, 0.0], [0.66, 0.03], 0.008);
    let step = drum(p, [0.0, 0.055, 0.0], [0.6, 0.03], 0.008);
    let upper = petal(angle_rad, radius, p.y, [0.57, 0.205, 0.085]);
    let lower = petal(
        angle_rad + 0.19634955,
        radius,
        0.32 - p.y,
        [0.57, 0.215, 0.075],
    );
    let stacked = seat.min(core).min(foot.min(step));
    stacked.min(upper.min(lower)) * 0.9
}

/// The nearest of 16 upright petals: [radius of the ring, height of the middle, half height].
fn petal(angle_rad: f32, radius: f32, y: f32, [ring_radius, middle, half]: [f32; 3]) -> f32 {
    let turn = std::f32::consts::TAU / 16.0;
    let local = angle_rad - (angle_rad / turn).round() * turn;
    let across = local * ring_radius;
    let lift = (y - middle) / half;
    let width = 0.105 * (1.0 - 0.42 * ramp(lift, 0.0, 1.0));
    let bulge = ring_radius - 0.045 + 0.02 * lift;
    let groove = 0.004 * fold(across * 190.0) * ramp(lift, 0.8, 0.2);
    let leaf = ellipsoid(
        Vec3::new(across, y, radius),
        [0.0, middle, bulge],
        [width, half, 0.05],
    );
    leaf - groove
}

/// A standing figure in a long pleated robe holding a bowl, 1.8 m high.
pub fn standing(cell: f32) -> Mesh {
    polygonise([[-0.55, -0.06, -0.5], [0.55, 1.92, 0.55]], cell, |p| {
        let q = Vec3::new(p.x.abs(), p.y, p.z);
        let robe = robe(p);
        // All but the robe hangs above half a metre.
        if robe + 0.08 < 0.5 - p.y {
            return robe * 0.9;
        }
        let upper_arm = limb(q, [0.2, 1.42, -0.02], [0.29, 1.14, 0.02], [0.075, 0.075]);
        let forearm = limb(q, [0.29, 1.14, 0.02], [0.11, 1.12, 0.24], [0.078, 0.085]);
        let drip = limb(q, [0.2, 1.1, 0.12], [0.22, 0.86, 0.14], [0.07, 0.045]);
        let wrinkle = 0.007 * fold((q.y * 0.9 + q.z * 0.8 - q.x * 0.5) * 62.0);
        let sleeves = blend(blend(upper_arm, forearm, 0.05), drip, 0.07) - wrinkle;
        let cuff = limb(q, [0.11, 1.12, 0.24], [0.05, 1.125, 0.3], [0.062, 0.02]);
        let sleeves = carve(sleeves, cuff - 0.006, 0.02);
        let hand = limb(q, [0.13, 1.12, 0.22], [0.04, 1.13, 0.315], [0.035, 0.03]);
        let bowl = carve(
            ellipsoid(p, [0.0, 1.2, 0.33], [0.11, 0.085, 0.11]),
            ellipsoid(p, [0.0, 1.255, 0.33], [0.094, 0.085, 0.094]),
            0.008,
        )
        .max(p.y - 1.235);
        let shawl = shawl(q);
        let neck = limb(q, [0.0, 1.45, -0.01], [0.0, 1.58, 0.0], [0.06, 0.05]);
        let crowned = crown(p).min(head(q, [0.0, 1.64, 0.01], false));
        let top = blend(neck, crowned, 0.02);
        let dressed = blend(blend(robe, sleeves, 0.04), shawl, 0.012);
        dressed.min(hand.min(bowl)).min(top) * 0.9
    })
}

/// The robe's radius over height, pleated more towards the hem.
fn robe(p: Vec3) -> f32 {
    let flat = Vec2::new(p.x * 0.82, p.z * 1.12);
    let radius = flat.length();
    let angle_rad = p.x.atan2(p.z);
    let flare = 0.17 + 0.17 * ramp(p.y, 1.0, -0.1) + 0.05 * ramp(p.y, 1.02, 1.3);
    let shoulder = 0.19 * ramp(p.y, 1.36, 1.56);
    let pleat = fold(angle_rad * 13.0 + 0.7 * (p.y * 4.0).sin() + 0.4 * (angle_rad * 3.0).sin());
    let amount = 0.006 + 0.026 * ramp(p.y, 1.0, 0.05);
    let belt = 0.018 * ramp((p.y - 1.03).abs(), 0.04, 0.025);
    let side = radius - (flare - shoulder) - amount * pleat * ramp(p.y, 1.45, 1.3) - belt;
    let top = p.y - 1.5;
    (-blend(-side, -top, 0.06)).max(-p.y) * 0.75
}

/// A scarf over both shoulders whose ends hang in front.
fn shawl(q: Vec3) -> f32 {
    let weave = 0.0015 * fold((q.x * 0.7 + q.y) * 200.0);
    let collar = limb(q, [0.0, 1.5, -0.13], [0.15, 1.5, -0.02], [0.05, 0.05]);
    let front = limb(q, [0.15, 1.5, -0.02], [0.105, 1.3, 0.17], [0.05, 0.045]);
    let end = limb(q, [0.105, 1.3, 0.17], [0.1, 0.62, 0.255], [0.045, 0.05]);
    blend(collar, front, 0.03).min(end) - weave
}

/// A tiara of leaves around the head.
fn crown(p: Vec3) -> f32 {
    let q = p - Vec3::new(0.0, 1.72, 0.0);
    let away = q.length() - 0.2;
    if away > 0.08 {
        return away;
    }
    let angle_rad = q.x.atan2(q.z);
    let turn = std::f32::consts::TAU / 9.0;
    let local = (angle_rad - (angle_rad / turn).round() * turn) * 0.115;
    let radius = Vec2::new(q.x, q.z).length();
    let leaf = ellipsoid(
        Vec3::new(local, q.y, radius),
        [0.0, 0.04, 0.118],
        [0.036, 0.075, 0.013],
    );
    let band = ring(q, [0.0, -0.015, 0.0], 0.116, 0.016);
    let cone = ellipsoid(q, [0.0, 0.04, -0.01], [0.09, 0.13, 0.09]);
    let tiers = 0.006 * fold(q.y * 110.0);
    blend(blend(leaf, band, 0.01), cone - tiers, 0.01)
}

/// An elephant under a saddle cloth, 1.7 m high.
pub fn elephant(cell: f32) -> Mesh {
    polygonise([[-0.98, -0.06, -1.2], [0.98, 1.95, 1.35]], cell, |p| {
        let q = Vec3::new(p.x.abs(), p.y, p.z);
        let barrel = ellipsoid(q, [0.0, 1.05, -0.25], [0.44, 0.47, 0.75]);
        let rump = ellipsoid(q, [0.0, 1.0, -0.65], [0.38, 0.45, 0.38]);
        let head = ellipsoid(q, [0.0, 1.32, 0.62], [0.26, 0.32, 0.29]);
        let dome = ball(q, [0.1, 1.53, 0.62], 0.15);
        let body = blend(blend(barrel, rump, 0.2), blend(head, dome, 0.12), 0.3);
        let front_leg = limb(q, [0.24, 0.9, 0.2], [0.24, 0.06, 0.24], [0.2, 0.135]);
        let hind_leg = limb(q, [0.24, 0.85, -0.72], [0.24, 0.06, -0.68], [0.23, 0.14]);
        let legs = front_leg.min(hind_leg);
        let toes = toes(q, 0.24).min(toes(q, -0.68));
        let legs = blend(legs, toes, 0.02).max(-p.y);
        let skin = 0.002 * fold(q.y * 85.0 + 2.5 * (q.z * 9.0).sin() + 2.0 * (p.x * 8.0).sin());
        let mut all = blend(body, legs - skin, 0.16);
        all = blend(all, trunk(p), 0.09);
        let eye = ball(q, [0.205, 1.36, 0.79], 0.035);
        let socket = ball(q, [0.235, 1.365, 0.81], 0.05);
        all = blend(carve(all, socket, 0.03), eye, 0.008);
        all = blend(all, ear(q), 0.05);
        let tusk_root = limb(q, [0.14, 1.12, 0.8], [0.19, 0.93, 1.05], [0.05, 0.042]);
        let tusk_tip = limb(q, [0.19, 0.93, 1.05], [0.15, 0.97, 1.26], [0.042, 0.012]);
        all = blend(all, tusk_root.min(tusk_tip), 0.012);
        blend(all, tail(p), 0.04).min(saddle(p)) * 0.85
    })
}

/// A ribbed ear that stands off the head, its root towards +z.
fn ear(q: Vec3) -> f32 {
    let away = (0.08 - q.z).max(0.85 - q.y);
    if away > 0.15 {
        return away;
    }
    let fan = q - Vec3::new(0.28, 1.3, 0.5);
    let turned = Vec3::new(
        fan.x * 0.78 + fan.z * 0.62,
        fan.y,
        fan.z * 0.78 - fan.x * 0.62,
    );
    let rib = 0.006 * fold(turned.y.atan2(turned.z + 0.25) * 15.0);
    ellipsoid(turned, [0.0, -0.03, -0.2], [0.03, 0.36, 0.27]) - rib
}

fn tail(p: Vec3) -> f32 {
    let before = p.z + 0.95;
    if before > 0.15 {
        return before;
    }
    let tail = limb(p, [0.0, 1.15, -1.0], [0.04, 0.6, -1.08], [0.045, 0.022]);
    tail.min(ellipsoid(p, [0.04, 0.53, -1.08], [0.035, 0.09, 0.035]))
}

/// Five toes around the front of the foot at `z`.
fn toes(q: Vec3, z: f32) -> f32 {
    let p = q - Vec3::new(0.24, 0.045, z);
    if p.y > 0.2 {
        return p.y - 0.05;
    }
    let angle_rad = p.x.atan2(p.z).clamp(-1.3, 1.3);
    let nearest = (angle_rad / 0.52).round() * 0.52;
    let (sine, cosine) = nearest.sin_cos();
    ellipsoid(p, [sine * 0.13, 0.0, cosine * 0.13], [0.034, 0.045, 0.034])
}

fn trunk(p: Vec3) -> f32 {
    let behind = 0.6 - p.z;
    if behind > 0.15 {
        return behind;
    }
    const POINTS: [[f32; 3]; 6] = [
        [0.0, 1.25, 0.82],
        [0.0, 0.95, 1.0],
        [0.02, 0.6, 1.04],
        [0.05, 0.32, 1.02],
        [0.08, 0.2, 1.12],
        [0.09, 0.27, 1.22],
    ];
    const RADII: [f32; 6] = [0.17, 0.125, 0.095, 0.078, 0.065, 0.055];
    let mut all = limb(p, POINTS[0], POINTS[1], [RADII[0], RADII[1]]);
    for i in 1..5 {
        let piece = limb(p, POINTS[i], POINTS[i + 1], [RADII[i], RADII[i + 1]]);
        all = blend(all, piece, 0.04);
    }
    all - 0.0045 * fold((p.y - 0.4 * p.z) * 75.0)
}

/// A cloth with a beaded border and a diamond pattern over the back.
fn saddle(p: Vec3) -> f32 {
    let edge = block(p, [0.0, 1.3, -0.3], [2.0, 0.42, 0.36], 0.03);
    if edge > 0.1 {
        return edge;
    }
    let hull = ellipsoid(p, [0.0, 1.05, -0.3], [0.475, 0.51, 0.78]);
    let diamonds = 0.008 * ((p.z * 42.0).sin() * (p.y * 42.0).sin()).abs();
    let trim = 0.014 * ramp(edge.abs(), 0.05, 0.03);
    (hull - diamonds - trim).max(edge).max(-hull - 0.06)
}
