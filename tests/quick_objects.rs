#[path = "it/objects.rs"]
mod objects;
#[path = "it/s3_server.rs"]
mod s3_server;
