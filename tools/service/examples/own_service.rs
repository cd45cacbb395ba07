//! A service of one's own, with tile files under `/maps`.
//!
//! `cargo run -p delaunay-tiles-service --example own_service -- town.tiles`

use std::net::Ipv4Addr;

use axum::Router;
use axum::routing::get;
use delaunay_tiles::Cache;
use delaunay_tiles_service::{Catalog, Options, router};
use tokio::net::TcpListener;

#[tokio::main]
async fn main() -> anyhow::Result<()> {
    let files: Vec<_> = std::env::args_os().skip(1).collect();
    // Tiles of all files share this cache; finished map tiles have one of their own.
    let catalog = Catalog::open(files.iter().map(std::path::Path::new), &Cache::new(256 << 20)).await?;
    let mut options = Options::default();
    options.max_tiles = 200;
    // Addresses in TileJSON begin with http://HOST/maps, as the request has it.
    let app = Router::new()
        .route("/", get(async || "this is my own page; the maps are at /maps/\n"))
        .nest("/maps", router(catalog, options));
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    println!("http://{}/maps/", listener.local_addr()?);
    axum::serve(listener, app).await?;
    Ok(())
}
