//! What methods find on the way.

use super::{Cells, ColumnEntry, Unit};

/// What methods find on the way and leave in `params`.
pub const FOUND: &[ColumnEntry] = &[
    found(
        ("lights_in_time", "lights or samples"),
        Unit::Count,
        "lights or samples that a budget of seconds pays for",
    ),
    found(
        ("reprojected", "reprojected"),
        Unit::None,
        "share of pixels that the frame before showed",
    ),
    found(
        ("rejected_reservoirs", "rejected reservoirs"),
        Unit::Count,
        "reservoirs of neighbours and of the frame before that are of another surface",
    ),
    found(("passes", "passes"), Unit::Count, "estimates of each pixel"),
    found(
        ("rays_of_records", "rays of records"),
        Unit::Count,
        "rays that the budget's records would take",
    ),
    found(
        ("allowed_error", "allowed error"),
        Unit::None,
        "allowed error that gives the budget's records",
    ),
    found(
        ("evaluated", "evaluated"),
        Unit::Count,
        "records that the search for the allowed error tried",
    ),
    found(
        ("misses", "misses"),
        Unit::Count,
        "lookups that found no record or no samples",
    ),
    found(
        ("threshold", "threshold"),
        Unit::None,
        "threshold of clusters, or of emissive texels",
    ),
    found(
        ("clusters", "clusters"),
        Unit::Count,
        "clusters before they are brought to the budget",
    ),
    found(
        ("min_cluster_size", "least cluster"),
        Unit::Count,
        "points of the least cluster that gets a record",
    ),
    found(
        ("sigma_a_deg", "σ_a"),
        Unit::None,
        "angular threshold, degrees",
    ),
    found(
        ("sigma_s", "σ_s"),
        Unit::None,
        "spatial threshold, scene units",
    ),
    found(
        ("alpha", "α"),
        Unit::None,
        "growth of the spatial threshold with distance",
    ),
    found(
        ("spatial_clusters", "spatial clusters"),
        Unit::Count,
        "clusters before they are split by angle",
    ),
    found(
        ("adjusted", "adjusted"),
        Unit::Count,
        "records added to reach the budget",
    ),
    found(
        ("proposals", "proposals"),
        Unit::Count,
        "pairs between which a record was proposed",
    ),
    found(
        ("least_difference", "least difference"),
        Unit::None,
        "difference at the last proposal taken",
    ),
    found(
        ("pairs", "pairs"),
        Unit::Count,
        "pairs of records that were compared",
    ),
    found(
        ("by_importance", "by importance"),
        Unit::Count,
        "records that the map's importance placed",
    ),
    found(
        ("by_gain", "by gain"),
        Unit::Count,
        "records that the expected gain placed",
    ),
    found(("modes", "modes"), Unit::Count, "modes of the map"),
    found(
        ("direct_lights", "direct lights"),
        Unit::Count,
        "lights on emissive texels",
    ),
    found(
        ("indirect_lights", "indirect lights"),
        Unit::Count,
        "lights on the other texels",
    ),
    found(
        ("emissive_texels", "emissive texels"),
        Unit::Count,
        "texels above the threshold",
    ),
    found(
        ("k_means_rounds", "k-means rounds"),
        Unit::Count,
        "rounds until the clusters stay",
    ),
    found(
        ("upsampling_fallbacks", "upsampling fallbacks"),
        Unit::None,
        "share of samples without a neighbour to upsample from",
    ),
    found(
        ("cells", "cells"),
        Unit::Count,
        "cells of the cache, of all levels",
    ),
    found(
        ("data_bytes", "data"),
        Unit::Bytes,
        "bytes of what all cells hold",
    ),
    found(
        ("map_bytes", "maps"),
        Unit::Bytes,
        "bytes of the maps of all levels",
    ),
    found(
        ("keyless_map_bytes", "maps without keys"),
        Unit::Bytes,
        "bytes that the maps of all levels would take as the paper's, 4.4 a cell",
    ),
    found(
        ("finest_density", "density"),
        Unit::None,
        "share of the finest level's cells that surfaces pass",
    ),
    found(
        ("finest_data_bytes", "data, finest"),
        Unit::Bytes,
        "bytes of what cells of the finest level hold",
    ),
    found(
        ("finest_map_bytes", "map, finest"),
        Unit::Bytes,
        "bytes of the finest level's map",
    ),
    found(
        ("finest_keyless_map_bytes", "map without keys, finest"),
        Unit::Bytes,
        "bytes that the finest level's map would take as the paper's",
    ),
    found(
        ("map_rebuilds", "map rebuilds"),
        Unit::Count,
        "how often building a map began anew with more slots",
    ),
    found(
        ("stored_samples", "stored samples"),
        Unit::Count,
        "samples that a frame gave to the cache",
    ),
    found(
        ("cells_updated", "cells updated"),
        Unit::Count,
        "cells that a frame changed, of all levels",
    ),
    found(
        ("absent_cells", "absent cells"),
        Unit::Count,
        "lookups where no cell is, which maps without keys would answer with another cell",
    ),
    found(
        ("holes", "holes"),
        Unit::None,
        "vertices of a camera sample whose cell had no samples",
    ),
    found(
        ("unfilled_holes", "unfilled holes"),
        Unit::None,
        "holes of a camera sample that no neighbour could fill, shown by coarser cells",
    ),
    found(
        ("cut_paths", "cut paths"),
        Unit::None,
        "share of camera samples that were still glossy at their last vertex",
    ),
    found(
        ("occupancy", "occupancy"),
        Unit::None,
        "share of the hash table's slots that are taken",
    ),
    found(
        ("evicted", "evicted"),
        Unit::Count,
        "cells or blocks that a frame gave up for their age",
    ),
    found(
        ("blended", "blended"),
        Unit::Count,
        "new cells of a frame that began with what another level holds",
    ),
    found(
        ("dropped_samples", "dropped samples"),
        Unit::Count,
        "samples of a frame that found no slot in the hash table, or lay outside of the first frame's cells",
    ),
    found(
        ("islands", "islands"),
        Unit::Count,
        "pieces of surface with a chart of their own",
    ),
    found(
        ("blocks", "blocks"),
        Unit::Count,
        "blocks of 8 × 8 texels that are kept",
    ),
    found(
        ("new_blocks", "new blocks"),
        Unit::Count,
        "blocks of texels that a frame added",
    ),
    found(
        ("refused_blocks", "refused blocks"),
        Unit::Count,
        "blocks of texels of a frame that found no room",
    ),
    found(
        ("texels", "texels"),
        Unit::Count,
        "texels that the viewers of a frame ask for together",
    ),
    found(
        ("block_fill", "block fill"),
        Unit::None,
        "share of the texels of blocks that are asked for",
    ),
    found(
        ("moved_texels", "moved texels"),
        Unit::Count,
        "texels of a frame that another surface cuts off, and that moved to what a camera sees",
    ),
    found(
        ("reused_texels", "reused texels"),
        Unit::Count,
        "texels of a frame that began with the cones of another size of texels",
    ),
    found(
        ("calm_texels", "texels at rest"),
        Unit::None,
        "share of a frame's texels whose light has been at rest",
    ),
    found(("cones", "cones"), Unit::None, "cones of a texel, mean"),
    found(
        ("light_samples", "light samples"),
        Unit::Count,
        "light samples of a frame's texels, with those that cast no ray",
    ),
    found(
        ("edge_tests", "edge tests"),
        Unit::Count,
        "rays of a frame near the edges of cones",
    ),
    found(
        ("active_bytes", "active"),
        Unit::Bytes,
        "bytes of the blocks of texels that are kept, of all viewers together",
    ),
    found(
        ("allocated_bytes", "allocated"),
        Unit::Bytes,
        "bytes that are set aside for blocks of texels, of all viewers together",
    ),
    found(
        ("uncached", "uncached"),
        Unit::None,
        "share of camera samples that no texel serves",
    ),
    found(
        ("other_texel_sizes", "other texel sizes"),
        Unit::None,
        "share of camera samples for which there are no texels of the size that suits them",
    ),
];

/// A number without a better way.
const fn found(
    (key, heading): (&'static str, &'static str),
    unit: Unit,
    meaning: &'static str,
) -> ColumnEntry {
    ColumnEntry {
        key,
        heading,
        unit,
        lower_is_better: None,
        meaning,
        cells: Cells::Found,
    }
}
