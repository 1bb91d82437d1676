//! What is computed: the cached functions and the truths.
