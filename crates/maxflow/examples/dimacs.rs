//! Solves a DIMACS maximum-flow file: `cargo run --release -p selvedge-maxflow --example dimacs -- FILE.max`
//!
//! Prints the flow, the size of the smallest source side (the source not counted), and the seconds of building the
//! graph and of solving it. A file that cannot be read is one line on stderr and exit code 3.

use std::fs::File;
use std::io::BufReader;
use std::process::ExitCode;
use std::time::Instant;

use selvedge_maxflow::dimacs::Problem;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: dimacs FILE.max");
        return ExitCode::from(2);
    };
    match solve(&path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: '{path}': {error}");
            ExitCode::from(3)
        }
    }
}

fn solve(path: &str) -> Result<(), Box<dyn std::error::Error>> {
    let problem = Problem::read(BufReader::new(File::open(path)?))?;
    let start = Instant::now();
    let mut graph = problem.graph()?;
    let build = start.elapsed();
    let cut = graph.solve()?;
    let solve = start.elapsed() - build;
    println!("flow {}", cut.flow);
    println!("source_side {}", problem.source_side_len(&cut));
    println!("seconds {:.6} {:.6}", build.as_secs_f64(), solve.as_secs_f64());
    Ok(())
}
