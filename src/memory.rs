//! Where trees and other large arrays live.

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
static ALLOCATED: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

/// Bytes that the program holds on its heap.
pub fn held() -> usize {
    ALLOCATED.current_usage()
}

/// The most memory that is held from a moment on. One at a time: starting another ends the first.
pub struct Peak {
    before: usize,
}

impl Peak {
    pub fn start() -> Self {
        ALLOCATED.reset_peak_usage();
        Self { before: held() }
    }

    /// Bytes beyond what was held at the start.
    pub fn bytes(&self) -> usize {
        ALLOCATED.peak_usage().saturating_sub(self.before)
    }
}
