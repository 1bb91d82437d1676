//! Splitting long lists at a rank, by all threads.

use rayon::prelude::*;

/// Lists longer than this are split by all threads.
const LONG: usize = 1 << 16;
/// Items of such a list whose order tells about where the rank lies.
const SAMPLES: usize = 4096;
/// How far from there the rank may be, in samples: about six standard deviations of random ones.
const MARGIN: usize = 200;
/// Items that one thread sorts out at a time.
const PART: usize = 1 << 14;

/// Orders by a coordinate, as [`f32::total_cmp`] does, then by a number.
pub(super) fn key(coordinate: f32, number: u32) -> u64 {
    let bits = coordinate.to_bits() as i32;
    let flipped = bits ^ (((bits >> 31) as u32) >> 1) as i32;
    u64::from(flipped as u32 ^ 0x8000_0000) << 32 | u64::from(number)
}

/// Reorders items so that the one of this rank is in its place, lesser ones before and greater ones behind it. Keys must
/// differ.
pub(super) fn at_rank<T: Copy + Send + Sync>(
    items: &mut [T],
    rank: usize,
    key: impl Fn(&T) -> u64 + Sync,
) {
    let (before, inside) = match items.len() > LONG {
        true => gather_near(items, rank, &key),
        false => (0, items.len()),
    };
    let place = rank.checked_sub(before).filter(|place| *place < inside);
    match place {
        Some(place) => {
            items[before..before + inside].select_nth_unstable_by_key(place, &key);
        }
        // The samples have misled.
        None => {
            items.select_nth_unstable_by_key(rank, &key);
        }
    }
}

/// Puts the items whose key is near that of the rank between those below and those above, all in their former order.
/// Returns how many are below, and how many near.
fn gather_near<T: Copy + Send + Sync>(
    items: &mut [T],
    rank: usize,
    key: &(impl Fn(&T) -> u64 + Sync),
) -> (usize, usize) {
    let sample = |i: usize| key(&items[i * items.len() / SAMPLES]);
    let mut samples: Vec<u64> = (0..SAMPLES).map(sample).collect();
    samples.sort_unstable();
    let at = rank * SAMPLES / items.len();
    let least = match at.checked_sub(MARGIN) {
        Some(first) => samples[first],
        None => 0,
    };
    let most = samples.get(at + MARGIN).copied().unwrap_or(u64::MAX);
    let class = |item: &T| {
        let key = key(item);
        usize::from(key >= least) + usize::from(key > most)
    };
    let former = items.par_iter().copied().collect::<Vec<T>>();
    let counts: Vec<[usize; 3]> = former
        .par_chunks(PART)
        .map(|part| {
            let mut counts = [0; 3];
            part.iter().for_each(|item| counts[class(item)] += 1);
            counts
        })
        .collect();
    let all = [0, 1, 2].map(|class| counts.iter().map(|counts| counts[class]).sum::<usize>());
    let (below, rest) = items.split_at_mut(all[0]);
    let (near, above) = rest.split_at_mut(all[1]);
    let mut rests = [below, near, above];
    let mut places = Vec::with_capacity(counts.len());
    for counts in counts {
        let own = |class: usize| rests[class].split_off_mut(..counts[class]);
        places.push([0, 1, 2].map(own).map(Option::unwrap_or_default));
    }
    let parts = former.par_chunks(PART).zip(places);
    parts.for_each(|(part, own)| {
        let mut used = [0; 3];
        for item in part {
            let class = class(item);
            own[class][used[class]] = *item;
            used[class] += 1;
        }
    });
    (all[0], all[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Rng;

    #[test]
    fn keys_order_as_coordinates_and_numbers() {
        let sorted = [
            f32::NEG_INFINITY,
            -3.0,
            -1e-40,
            -0.0,
            0.0,
            1e-40,
            2.5,
            f32::INFINITY,
        ];
        assert!(sorted.windows(2).all(|w| key(w[0], 9) < key(w[1], 3)));
        assert!(key(1.0, 3) < key(1.0, 4));
    }

    #[test]
    fn long_lists_are_split_as_short_ones() {
        let count = 3 * LONG + 17;
        let mut rng = Rng::new(1, 2, 3, 4);
        let random: Vec<u32> = (0..count)
            .map(|_| (4096.0 * rng.next_f32()) as u32)
            .collect();
        let rising: Vec<u32> = (0..count as u32).collect();
        // Where samples are taken everything is 0.
        let misleading: Vec<u32> = (0..count)
            .map(|i| u32::from((0..SAMPLES).all(|s| s * count / SAMPLES != i)) * i as u32)
            .collect();
        for (name, values) in [
            ("random", random),
            ("rising", rising),
            ("misleading", misleading),
        ] {
            let mut items: Vec<(u32, u32)> = (0u32..).zip(values).map(|(i, v)| (v, i)).collect();
            let key = |item: &(u32, u32)| u64::from(item.0) << 32 | u64::from(item.1);
            let mut sorted = items.clone();
            sorted.sort_unstable_by_key(key);
            for rank in [0, 1, count / 3, count / 2, count - 1] {
                at_rank(&mut items, rank, key);
                assert_eq!(items[rank], sorted[rank], "{name}");
                let middle = key(&items[rank]);
                assert!(
                    items[..rank].iter().all(|item| key(item) < middle),
                    "{name}"
                );
                assert!(
                    items[rank + 1..].iter().all(|item| key(item) > middle),
                    "{name}"
                );
            }
        }
    }
}
