//! The data services of `flaneur.v1` over a [`crate::store`].
