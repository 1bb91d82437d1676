//! Where trees and other large arrays live, and how much memory is held.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// Moves the items into memory of exactly their size that is asked to be in huge pages: a visit of a
/// large tree otherwise often waits for the address of a page before it waits for the page.
#[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
pub fn in_huge_pages<T>(items: Vec<T>) -> Vec<T> {
    let mut moved = room_for(items.len());
    moved.extend(items);
    moved
}

/// An empty vector with room for `count` items, in huge pages if they are many.
pub fn room_for<T>(count: usize) -> Vec<T> {
    let mut room = Vec::with_capacity(count);
    ask_for_huge_pages(&mut room);
    room
}

/// The items of all lists, one list after another. All threads write them and give back the lists: one alone would wait
/// for each page of either.
pub fn concatenated<T: Clone + Send + Sync>(mut lists: Vec<Vec<T>>) -> Vec<T> {
    if lists.len() == 1 {
        return lists.remove(0);
    }
    let Some(some) = lists.iter().flatten().next() else {
        return Vec::new();
    };
    let count = lists.iter().map(Vec::len).sum();
    let mut all = Vec::with_capacity(count);
    all.par_extend(rayon::iter::repeat_n(some.clone(), count));
    let mut rest = &mut all[..];
    let places: Vec<_> = lists
        .into_iter()
        .map(|list| {
            let (own, tail) = std::mem::take(&mut rest).split_at_mut(list.len());
            rest = tail;
            (own, list)
        })
        .collect();
    let places = places.into_par_iter();
    places.for_each(|(own, list)| own.clone_from_slice(&list));
    all
}

/// Advice for the whole huge pages within the vector's memory, best given before they are first
/// written. Without effect, but harmless, where the system does not follow it.
#[cfg(target_os = "linux")]
fn ask_for_huge_pages<T>(vector: &mut Vec<T>) {
    use rustix::mm::{Advice, madvise};
    const HUGE_PAGE: usize = 2 << 20;
    let memory = vector.spare_capacity_mut();
    let bytes = size_of_val(memory);
    let start = memory.as_mut_ptr().cast::<u8>();
    let skipped = start.align_offset(HUGE_PAGE);
    if bytes < 4 * HUGE_PAGE || skipped > HUGE_PAGE {
        return;
    }
    let whole = (bytes - skipped) / HUGE_PAGE * HUGE_PAGE;
    // SAFETY: the range lies within memory that `vector` owns, and this advice changes no contents.
    // A refusal costs a few percent of speed and nothing else.
    let _ = unsafe { madvise(start.add(skipped).cast(), whole, Advice::LinuxHugepage) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_huge_pages<T>(_: &mut Vec<T>) {}

/// Counts what is allocated, so that the memory of every technique is measured the same way.
#[global_allocator]
static ALLOCATED: Counting = Counting {
    held: AtomicUsize::new(0),
    most: AtomicUsize::new(0),
};

thread_local! {
    /// Bytes that this thread took from the heap less those that it gave back, whoever took them.
    static OWN: Cell<isize> = const { Cell::new(0) };
}

/// The system's allocator, which says how much is held. Zeroed memory and growth are left to the system: pages
/// that nobody has written yet cost nothing, and long arrays grow without being copied.
struct Counting {
    held: AtomicUsize,
    most: AtomicUsize,
}

impl Counting {
    fn add(&self, bytes: usize) {
        OWN.set(OWN.get().wrapping_add_unsigned(bytes));
        let held = self.held.fetch_add(bytes, Ordering::Relaxed) + bytes;
        // Mostly there is nothing to write.
        if held > self.most.load(Ordering::Relaxed) {
            self.most.fetch_max(held, Ordering::Relaxed);
        }
    }

    fn remove(&self, bytes: usize) {
        OWN.set(OWN.get().wrapping_sub_unsigned(bytes));
        self.held.fetch_sub(bytes, Ordering::Relaxed);
    }
}

// SAFETY: all memory comes from the system's allocator and goes back to it, as it is asked for; counting changes
// nothing of that and allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller's promise about the layout is passed on.
        let memory = unsafe { System.alloc(layout) };
        if !memory.is_null() {
            self.add(layout.size());
        }
        memory
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as in `alloc`.
        let memory = unsafe { System.alloc_zeroed(layout) };
        if !memory.is_null() {
            self.add(layout.size());
        }
        memory
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise, that this memory was allocated here with this layout, is passed on.
        unsafe { System.dealloc(memory, layout) };
        self.remove(layout.size());
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as in `dealloc`, and the caller promises that the new size is a valid one.
        let moved = unsafe { System.realloc(memory, layout, size) };
        if !moved.is_null() {
            self.add(size);
            self.remove(layout.size());
        }
        moved
    }
}

/// Bytes that the program holds on its heap.
pub fn held() -> usize {
    ALLOCATED.held.load(Ordering::Relaxed)
}

/// Bytes of heap that something holds and nobody shares: what this thread gives back when it is dropped, room for more
/// included. Whatever other threads do meanwhile, it is the same.
pub fn released<T>(held: T) -> usize {
    let before = OWN.get();
    drop(held);
    before.wrapping_sub(OWN.get()).max(0).cast_unsigned()
}

/// The most memory that is held from a moment on. One at a time: starting another ends the first.
pub struct Peak {
    before: usize,
}

impl Peak {
    /// From now on.
    pub fn start() -> Self {
        let before = held();
        ALLOCATED.most.store(before, Ordering::Relaxed);
        Self { before }
    }

    /// Bytes beyond what was held at the start.
    pub fn bytes(&self) -> usize {
        let most = ALLOCATED.most.load(Ordering::Relaxed);
        most.saturating_sub(self.before)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::released;

    #[test]
    fn what_is_released_is_what_was_held_alone() {
        assert_eq!(released(()), 0);
        assert_eq!(released([1, 2, 3]), 0);
        assert_eq!(released(Vec::<u64>::with_capacity(100)), 800);
        assert_eq!(released((Box::new([0u8; 24]), vec![vec![0u16; 5]])), 58);
        let shared = Arc::new([0u8; 1000]);
        assert_eq!(released(Arc::clone(&shared)), 0);
        assert!(released(shared) >= 1000);
        // Whoever took it.
        let far = std::thread::spawn(|| vec![0u8; 70]).join();
        assert_eq!(released(far.expect("no panic")), 70);
    }

    #[test]
    fn lists_follow_one_another() {
        let lists: Vec<Vec<String>> = [&["a", "b"][..], &[], &["c"]]
            .map(|list| list.iter().map(|&item| item.to_owned()).collect())
            .to_vec();
        assert_eq!(super::concatenated(lists), ["a", "b", "c"]);
        assert!(super::concatenated(vec![Vec::<u8>::new()]).is_empty());
    }
}
