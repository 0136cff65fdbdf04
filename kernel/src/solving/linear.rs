//! Kratos's names of linear solvers, mapped onto the few that Bia has.

use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind, Parameters, Range};
pub use bia_linalg::Nature;
use bia_linalg::{IterativeSettings, Method, Preconditioner};

/// Keys that Kratos's linear solvers take; those without a meaning here are accepted.
const KEYS: &[Key] = &[
    Key::new("solver_type", Kind::Text, "\"automatic\"", "name of the linear solver"),
    Key::new("tolerance", Kind::Number(Range::POSITIVE), "1e-7", "relative residual of iterative solvers")
        .or(&["krylov_tolerance"]),
    Key::new("max_iteration", Kind::Integer { min: 1 }, "1000", "most iterations of iterative solvers")
        .or(&["max_iterations"]),
    Key::optional("krylov_type", Kind::Text, "cg, bicgstab, gmres, …: chooses the method inside amgcl"),
    Key::optional("preconditioner_type", Kind::Any, "accepted; Bia chooses"),
    Key::optional("smoother_type", Kind::Any, "accepted; Bia chooses"),
    Key::optional("coarsening_type", Kind::Any, "accepted; Bia chooses"),
    Key::optional("coarse_enough", Kind::Any, "accepted"),
    Key::optional("scaling", Kind::Any, "accepted"),
    Key::optional("verbosity", Kind::Any, "accepted"),
    Key::optional("echo_level", Kind::Any, "accepted"),
    Key::optional("provide_coordinates", Kind::Any, "accepted"),
    Key::optional("gmres_krylov_space_dimension", Kind::Any, "accepted"),
    Key::optional("use_block_matrices_if_possible", Kind::Any, "accepted"),
    Key::optional("block_size", Kind::Any, "accepted"),
    Key::optional("max_levels", Kind::Any, "accepted"),
    Key::optional("pre_sweeps", Kind::Any, "accepted"),
    Key::optional("post_sweeps", Kind::Any, "accepted"),
    Key::optional("use_gpgpu", Kind::Any, "accepted"),
    Key::optional("amgcl_custom_parameters", Kind::Any, "accepted"),
    Key::optional("inner_solver_settings", Kind::Any, "accepted"),
    Key::optional("solver_info", Kind::Any, "accepted"),
    Key::optional("precond_type", Kind::Any, "accepted"),
    Key::optional("mkl_pardiso", Kind::Any, "accepted"),
];

const DIRECT: &[&str] = &[
    "skyline_lu_factorization",
    "skyline_lu_complex",
    "super_lu",
    "super_lu_iterative",
    "sparse_lu",
    "sparse_qr",
    "pardiso_lu",
    "pardiso_lu_complex",
    "mixedup",
];
const SYMMETRIC_DIRECT: &[&str] = &["sparse_cg_direct", "pardiso_ldlt", "pardiso_llt", "cholesky", "ldlt"];
const MULTIGRID: &[&str] = &["amgcl", "amgcl_raw", "amgcl_ns_solver"];
const KRYLOV: &[&str] = &["cg", "bicgstab", "gmres", "sparse_cg", "tfqmr", "deflated_cg", "fgmres"];

/// The method for `linear_solver_settings`; none given means automatic.
///
/// A direct solver is a direct one here too, but the factorisation that fits the system is used;
/// large 3D systems asked of an iterative one are solved by it, small ones directly, which is
/// both faster and more exact. Displacement-pressure systems are indefinite: direct solvers begin with `L D L^T` or LU,
/// and all Krylov methods become GMRES on the equilibrated matrix, so that rows of small units count.
///
/// # Errors
/// Unknown names and keys.
pub fn method(parameters: Option<&Parameters>, nature: Nature) -> Result<Method, InputErrors> {
    let exact = match (nature.symmetric, nature.definite) {
        (true, true) => Method::Symmetric,
        (true, false) => Method::Ldlt,
        (false, _) => Method::Lu,
    };
    let automatic = |tolerance: f64| Method::Automatic { nature, tolerance };
    let Some(parameters) = parameters.filter(|p| p.value().as_object().is_none_or(|o| !o.is_empty())) else {
        return Ok(automatic(1e-9));
    };
    let settings = parameters.read(KEYS)?;
    let given = settings.text("solver_type");
    let name = given.rsplit('.').next().unwrap_or(given).to_lowercase();
    let tolerance = settings.number("tolerance");
    let max_iterations = settings.integer("max_iteration") as usize;
    let iterative = IterativeSettings { maximum_iterations: max_iterations, ..IterativeSettings::new(tolerance) };
    match name.as_str() {
        "automatic" => Ok(automatic(tolerance)),
        multigrid if MULTIGRID.contains(&multigrid) => Ok(automatic(tolerance)),
        krylov if !nature.definite && KRYLOV.contains(&krylov) => {
            Ok(Method::Gmres(IterativeSettings { preconditioner: Preconditioner::Incomplete, ..iterative }))
        }
        "cg" | "sparse_cg" | "deflated_cg" if nature.symmetric => Ok(Method::ConjugateGradient(iterative)),
        krylov if KRYLOV.contains(&krylov) => Ok(Method::BiCgStab(iterative)),
        "lu" => Ok(Method::Lu),
        direct if DIRECT.contains(&direct) || SYMMETRIC_DIRECT.contains(&direct) => Ok(exact),
        _ => {
            let lists = [&["automatic", "lu"], DIRECT, SYMMETRIC_DIRECT, MULTIGRID, KRYLOV];
            let names = lists.into_iter().flatten().copied();
            Err(settings
                .error("solver_type", format!("there is no linear solver {given:?}"))
                .allowed(&name, names)
                .into())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Document;
    use std::path::Path;

    fn chosen(text: &str, symmetric: bool) -> Result<String, InputErrors> {
        let parameters = Parameters::root(Document::parse(Path::new("p"), text.into())?);
        let nature = Nature { symmetric, definite: true, dimension: 2 };
        method(Some(&parameters), nature).map(|m| format!("{m:?}"))
    }

    #[test]
    fn saddle_points_get_methods_for_indefinite_matrices() {
        for (text, symmetric, expected) in [
            (r#"{"solver_type": "skyline_lu_factorization"}"#, true, "Ldlt"),
            (r#"{"solver_type": "pardiso_lu"}"#, false, "Lu"),
            (r#"{"solver_type": "cg"}"#, true, "Gmres"),
            (r#"{"solver_type": "bicgstab"}"#, false, "Gmres"),
            (r#"{"solver_type": "amgcl"}"#, false, "Automatic"),
        ] {
            let parameters = Parameters::root(Document::parse(Path::new("p"), text.into()).unwrap());
            let nature = Nature { symmetric, definite: false, dimension: 3 };
            let chosen = format!("{:?}", method(Some(&parameters), nature).unwrap());
            assert!(chosen.starts_with(expected), "{text}: {chosen}");
        }
    }

    #[test]
    fn kratos_names_are_understood() {
        let lu = r#"{"solver_type": "LinearSolversApplication.sparse_lu"}"#;
        assert!(chosen(lu, true).unwrap().starts_with("Symmetric"));
        assert!(chosen(lu, false).unwrap().starts_with("Lu"));
        assert!(chosen(r#"{"solver_type": "cg"}"#, true).unwrap().starts_with("ConjugateGradient"));
        assert!(chosen(r#"{"solver_type": "cg"}"#, false).unwrap().starts_with("BiCgStab"));
        assert!(chosen(r#"{"solver_type": "amgcl", "smoother_type": "ilu0"}"#, true).unwrap().starts_with("Automatic"));
        let error = chosen(r#"{"solver_type": "sparse_lo"}"#, true).unwrap_err().to_string();
        assert!(error.contains("did you mean \"sparse_lu\""), "{error}");
    }
}
