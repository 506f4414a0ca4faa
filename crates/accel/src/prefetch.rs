//! Asking for memory ahead of its use.

/// Brings the cache line of `target` nearer; changes nothing else.
#[inline(always)]
pub(crate) fn prefetch<T>(target: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        #[expect(
            unsafe_code,
            reason = "a prefetch reads nothing, and the address is a reference's"
        )]
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(target).cast::<i8>());
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = target;
}

/// Brings all cache lines of an element nearer, if there is such an element.
#[inline(always)]
pub(crate) fn prefetch_all<T>(slice: &[T], index: usize) {
    const LINE: usize = 64;
    let Some(element) = slice.get(index) else { return };
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(element).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(LINE) {
            #[expect(
                unsafe_code,
                reason = "a prefetch reads nothing, and the addresses are within a reference's"
            )]
            unsafe {
                _mm_prefetch::<_MM_HINT_T0>(start.add(offset));
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (element, LINE);
}
