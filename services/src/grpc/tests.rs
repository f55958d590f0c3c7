//! The services over a street that the layers' own writers wrote.

mod answers;
mod errors;
mod leaving;
mod network;
mod streams;
mod street;
mod watched;
