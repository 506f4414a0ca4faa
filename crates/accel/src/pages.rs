//! Memory in large pages.
//!
//! Light reads blocks all over the snow: with pages of 4 KiB nearly every read would first have to
//! find its page.

fn prefer_large_pages<T>(items: &mut [T]) {
    #[cfg(target_os = "linux")]
    {
        use rustix::mm::{Advice, madvise};
        // The advice is for whole pages of the smallest size.
        const PAGE: usize = 4096;
        let start = items.as_mut_ptr() as usize;
        let first = start.next_multiple_of(PAGE);
        let end = (start + size_of_val(items)) / PAGE * PAGE;
        if first >= end {
            return;
        }
        #[expect(
            unsafe_code,
            reason = "the pages lie within the slice, and this advice changes no contents"
        )]
        // A refusal leaves small pages, which work too.
        let _ = unsafe {
            madvise(
                items.as_mut_ptr().wrapping_byte_add(first - start).cast(),
                end - first,
                Advice::LinuxHugepage,
            )
        };
    }
    #[cfg(not(target_os = "linux"))]
    let _ = items;
}

/// `count` items of zero bytes, in large pages where the system has them.
pub(crate) fn zeroed<T: bytemuck::Zeroable + Clone>(count: usize) -> Vec<T> {
    let mut items = Vec::with_capacity(count);
    // Before the memory is first written: asked for zeroed memory, the allocator would write that of
    // an aligned type itself, in small pages.
    prefer_large_pages(items.spare_capacity_mut());
    items.resize(count, T::zeroed());
    items
}
