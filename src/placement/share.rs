//! Sharing items out among threads, part by part.

use std::ops::Range;

/// Parts of some items that one thread works on.
pub(super) struct Share<'a, T, P> {
    pub parts: &'a [P],
    /// From the first item of the first part to the last one of the last.
    items: &'a mut [T],
    /// Place of the first of them among all.
    begin: usize,
}

impl<T, P> Share<'_, T, P> {
    /// The items in a range among all.
    pub fn items(&mut self, range: Range<usize>) -> &mut [T] {
        &mut self.items[range.start - self.begin..range.end - self.begin]
    }
}

/// Shares of `together` parts each; the ranges of parts follow one another.
pub(super) fn shares<'a, T, P>(
    items: &'a mut [T],
    parts: &'a [P],
    together: usize,
    range: impl Fn(&P) -> Range<usize>,
) -> Vec<Share<'a, T, P>> {
    let (mut rest, mut start) = (items, 0);
    let share = |parts: &'a [P]| {
        let [begin, end] = [range(&parts[0]).start, range(&parts[parts.len() - 1]).end];
        let (_, tail) = std::mem::take(&mut rest).split_at_mut(begin - start);
        let (items, tail) = tail.split_at_mut(end - begin);
        (rest, start) = (tail, end);
        Share {
            parts,
            items,
            begin,
        }
    };
    parts.chunks(together).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_has_its_own_items_and_gaps_between_them_have_none() {
        let mut items: Vec<u32> = (0..20).collect();
        let parts = [0..3, 5..6, 6..6, 6..11, 15..20];
        for together in 1..7 {
            let mut found = Vec::new();
            for mut share in shares(&mut items, &parts, together, Clone::clone) {
                for part in share.parts {
                    found.extend(share.items(part.clone()).iter().copied());
                }
            }
            let expected: Vec<u32> = parts
                .iter()
                .flat_map(|p| p.start as u32..p.end as u32)
                .collect();
            assert_eq!(found, expected);
        }
        let none: [Range<usize>; 0] = [];
        assert!(shares(&mut items, &none, 3, Clone::clone).is_empty());
    }
}
