//! Files that lie, or are damaged: one clear line each, and never a panic.
