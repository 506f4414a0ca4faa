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
