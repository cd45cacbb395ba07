//! What comes in: readers for point files.
