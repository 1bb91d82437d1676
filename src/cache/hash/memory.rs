//! What was learned, apart from the structure, which the scene that it was made of gives anew.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::levels::{HashCells, Level};

/// The cells of a level that have samples.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LevelMemory {
    /// All cells of the level, with or without samples.
    cells: u64,
    /// Cells without samples before each one with samples.
    gaps: Vec<u32>,
    /// Their contents but for the stamp.
    words: Vec<u32>,
}

impl HashCells {
    /// What the cells hold, from the coarsest level.
    pub fn memory(&self) -> Vec<LevelMemory> {
        (0..=self.grid.levels())
            .zip(&self.levels)
            .map(|(number, level)| self.memory_of(number, level))
            .collect()
    }

    fn memory_of(&self, number: u32, level: &Level) -> LevelMemory {
        let size = self.precision.words();
        let written: Vec<usize> = (0..level.cells)
            .into_par_iter()
            .filter(|&index| self.cell(number, index as u32).has_samples())
            .collect();
        let mut memory = LevelMemory {
            cells: level.cells as u64,
            gaps: Vec::with_capacity(written.len()),
            words: Vec::with_capacity(written.len() * (size - 1)),
        };
        let mut next = 0;
        for index in written {
            memory.gaps.push((index - next) as u32);
            let start = index * size;
            memory.words.extend(&level.words[start..start + size - 1]);
            next = index + 1;
        }
        memory
    }

    /// Makes the cells hold what others of the same scene and options held.
    ///
    /// # Errors
    ///
    /// A sentence if they were of another scene or had other options; the cells then are wiped.
    pub fn recall(&mut self, memory: &[LevelMemory]) -> Result<(), String> {
        self.wipe();
        let size = self.precision.words();
        let fits = |(level, memory): (&Level, &LevelMemory)| {
            let last: u64 = memory.gaps.iter().map(|&gap| u64::from(gap) + 1).sum();
            memory.cells == level.cells as u64
                && last <= memory.cells
                && memory.words.len() == memory.gaps.len() * (size - 1)
        };
        if memory.len() != self.levels.len() || !self.levels.iter().zip(memory).all(fits) {
            return Err("what was remembered is of other cells: of another scene, or with another number of levels or precision".into());
        }
        for (level, memory) in self.levels.iter_mut().zip(memory) {
            let mut next = 0;
            for (&gap, words) in memory.gaps.iter().zip(memory.words.chunks_exact(size - 1)) {
                let index = next + gap as usize;
                let cell = &mut level.words[index * size..(index + 1) * size];
                cell[..size - 1].copy_from_slice(words);
                cell[size - 1] = self.stamp;
                next = index + 1;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::hash::Options;
    use crate::cache::hash::levels::tests::{HALF, SINGLE, cells, corner, random_samples};

    #[test]
    fn memory_gives_the_same_looks() {
        for options in [HALF, SINGLE] {
            let mut before = cells(options);
            before.update(random_samples(1, 100));
            before.wipe();
            before.update(random_samples(2, 300));
            let bytes = postcard::to_allocvec(&before.memory()).expect("serialised");
            let memory: Vec<LevelMemory> = postcard::from_bytes(&bytes).expect("read");
            let mut after = cells(options);
            after.update(random_samples(3, 300));
            after.recall(&memory).expect("the same cells");
            assert_eq!(after.memory(), memory);
            // And they go on the same.
            for seed in [4, 5] {
                for probe in random_samples(seed, 500) {
                    for level in 0..=5 {
                        let look = |c: &HashCells| c.look(level, probe.position, probe.normal);
                        assert_eq!(look(&before), look(&after));
                    }
                }
                before.update(random_samples(seed, 300));
                after.update(random_samples(seed, 300));
            }
        }
        let memory = cells(HALF).memory();
        assert!(
            cells(Options { levels: 4, ..HALF })
                .recall(&memory)
                .is_err()
        );
        let mut learned = cells(HALF);
        learned.update(random_samples(1, 10));
        assert!(cells(SINGLE).recall(&learned.memory()).is_err());
        let (positions, triangles) = corner();
        let mut other = HashCells::new(&positions, &triangles[..2], HALF).expect("few cells");
        assert!(other.recall(&memory).is_err());
    }
}
