//! Error metrics between a reference and a test image, and statistics over repeats.
