//! What the programs, the bench and the tests of the laboratory share. The program `lab` has the experiments.

pub mod kernels;
