//! Seeded point sets and PSLGs to test and measure triangulations with.
