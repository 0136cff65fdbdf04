//! Faults of the materials file and of materials that do not fit the scene.

use super::base::{BODY, MATERIALS, PROJECT, Scene, part, refuse};

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";

#[test]
fn file() {
    refuse(&[
        ("missing", |s| s.remove(MATERIALS), &["ParticleMaterials.json", "cannot be read", "ProjectParameters.json"]),
        (
            "not named",
            |s| {
                s.replace(
                    PROJECT,
                    "{\"materials_filename\": \"ParticleMaterials.json\"}",
                    "{\"materials_filename\": \"\"}",
                )
            },
            &["at /solver_settings/material_import_settings", "\"materials_filename\" is missing"],
        ),
        (
            "syntax",
            |s| s.replace(MATERIALS, "\"THICKNESS\": 1.0,", "\"THICKNESS\": 1.0"),
            &["ParticleMaterials.json:9:", "is not JSON"],
        ),
        ("infinite", |s| s.replace(MATERIALS, "1e6", "1e400"), &["ParticleMaterials.json:11:", "number out of range"]),
        ("no list", |s| s.write(MATERIALS, "{}"), &["the list \"properties\" is missing"]),
        (
            "empty list",
            |s| s.write(MATERIALS, "{\"properties\": []}"),
            &["body element 101", "has no material", "parts: Cube"],
        ),
        (
            "key",
            |s| s.replace(MATERIALS, "\"properties_id\"", "\"property_id\""),
            &["at /properties/0/property_id", "the key \"property_id\" is unknown", "did you mean \"properties_id\"?"],
        ),
        (
            "key twice",
            |s| s.replace(MATERIALS, "\"DENSITY\": 1000.0,", "\"DENSITY\": 1000.0, \"DENSITY\": 10.0,"),
            &["ParticleMaterials.json:10:", "at /properties/0/Material/Variables/DENSITY", "stands twice"],
        ),
        (
            "id twice",
            |s| {
                let text = s.text(MATERIALS);
                let entry = &text[text.find("{\n        \"model").unwrap()..text.rfind(']').unwrap()];
                let both = text.replace(entry, &format!("{entry}, {entry}"));
                s.write(MATERIALS, both)
            },
            &["at /properties/1", "properties_id 1 stands twice"],
        ),
        (
            "huge id",
            |s| s.replace(MATERIALS, "\"properties_id\": 1", "\"properties_id\": 5000000000"),
            &["at /properties/0/properties_id", "5000000000", "4294967295"],
        ),
        (
            "variables a list",
            |s| s.replace(MATERIALS, "\"Variables\": {", "\"Variables\": [], \"Tables\": {"),
            &["at /properties/0/Material/Variables", "is the list [], must be an object"],
        ),
        (
            "old and new name",
            |s| s.replace(MATERIALS, "\"DENSITY\"", "\"PARTICLES_PER_ELEMENT\": 4, \"DENSITY\""),
            &["MATERIAL_POINTS_PER_ELEMENT", "PARTICLES_PER_ELEMENT", "both"],
        ),
    ]);
}

#[test]
fn parts() {
    refuse(&[
        (
            "unknown",
            |s| s.replace(MATERIALS, "Initial_MPM_Material.Cube", "Initial_MPM_Material.Qube"),
            &[
                "ParticleMaterials.json:3:28 at /properties/0/model_part_name",
                "there is no part \"Initial_MPM_Material.Qube\"",
                "did you mean \"Initial_MPM_Material.Cube\"?",
            ],
        ),
        (
            "root",
            |s| s.replace(MATERIALS, "Initial_MPM_Material.Cube", "Background_Grid"),
            &["there is no part \"Background_Grid\" of the bodies"],
        ),
        (
            "for nothing",
            |s| s.replace(MATERIALS, ".Cube", ".Empty").append(BODY, "Begin SubModelPart Empty\nEnd SubModelPart\n"),
            &["has no elements, so its material is for nothing"],
        ),
        (
            "one left out",
            |s| {
                s.append(BODY, "Begin Elements MPMUpdatedLagrangian2D3N\n150 0 101 102 104\nEnd Elements\n")
                    .append(BODY, &part("Other", 101..=102, 150..=150))
            },
            &["Body.mdpa:", "body element 150", "has no material", "Cube, Other"],
        ),
    ]);
}

#[test]
fn laws() {
    refuse(&[
        (
            "unknown",
            |s| s.replace(MATERIALS, LAW, "NoSuchLaw2D"),
            &["at /properties/0/Material", "unknown constitutive law \"NoSuchLaw2D\"", LAW],
        ),
        (
            "misspelt",
            |s| s.replace(MATERIALS, LAW, "HyperElasticNeoHookeanPlainStrain2DLaw"),
            &["did you mean \"HyperElasticNeoHookeanPlaneStrain2DLaw\"?"],
        ),
        (
            "none",
            |s| {
                s.replace(
                    MATERIALS,
                    "\"constitutive_law\": {\"name\": \"HyperElasticNeoHookeanPlaneStrain2DLaw\"},",
                    "",
                )
            },
            &["names no constitutive law", LAW],
        ),
        (
            "of space",
            |s| s.replace(MATERIALS, LAW, "HyperElasticNeoHookean3DLaw"),
            &["is for three-dimensional or uniaxial strain elements", "use HyperElasticNeoHookeanPlaneStrain2DLaw"],
        ),
        (
            "axisymmetric law",
            |s| s.replace(MATERIALS, LAW, "HyperElasticNeoHookeanAxisym2DLaw"),
            &["is for axisymmetric elements, but these elements are plane strain", LAW],
        ),
        (
            "axisymmetric scene",
            |s| s.replace(PROJECT, "\"axis_symmetric_flag\": false", "\"axis_symmetric_flag\": true"),
            &["these elements are axisymmetric", "use HyperElasticNeoHookeanAxisym2DLaw"],
        ),
        (
            "of the mixed formulation",
            |s| s.replace(MATERIALS, LAW, "HyperElasticNeoHookeanPlaneStrainUP2DLaw"),
            &["HyperElasticNeoHookeanPlaneStrainUP2DLaw needs nodal pressures", "set \"pressure_dofs\" to true", LAW],
        ),
        (
            "plasticity",
            |s| s.replace(MATERIALS, LAW, "HenckyMCPlasticPlaneStrain2DLaw"),
            &["\"HenckyMCPlasticPlaneStrain2DLaw\" is known to Kratos, but not in this build", LAW],
        ),
        (
            "Johnson-Cook",
            |s| s.replace(MATERIALS, LAW, "JohnsonCookThermalPlastic2DPlaneStrainLaw"),
            &["known to Kratos, but not in this build", LAW],
        ),
        (
            "Cam-Clay",
            |s| {
                s.replace(MATERIALS, LAW, "KratosMultiphysics.MPMApplication.HenckyBorjaCamClayPlasticPlaneStrain2DLaw")
            },
            &["known to Kratos, but not in this build", LAW],
        ),
    ]);
}

#[test]
fn constants() {
    refuse(&[
        (
            "unknown",
            |s| s.replace(MATERIALS, "\"YOUNG_MODULUS\"", "\"YOUNG_MODULLUS\""),
            &[
                "ParticleMaterials.json:11:35 at /properties/0/Material/Variables/YOUNG_MODULLUS",
                "the material variable \"YOUNG_MODULLUS\" is unknown",
                "did you mean \"YOUNG_MODULUS\"?",
            ],
        ),
        (
            "no density",
            |s| s.replace(MATERIALS, "\"DENSITY\": 1000.0,", ""),
            &["ParticleMaterials.json:7:26", "DENSITY is missing", "kg/m³", "1 error in the input"],
        ),
        ("no modulus", |s| s.replace(MATERIALS, "\"YOUNG_MODULUS\": 1e6,", ""), &["YOUNG_MODULUS is missing", "[Pa]"]),
        ("no thickness", |s| s.replace(MATERIALS, "\"THICKNESS\": 1.0,", ""), &["THICKNESS is missing"]),
        (
            "no points",
            |s| s.replace(MATERIALS, "\"MATERIAL_POINTS_PER_ELEMENT\": 4,", ""),
            &["MATERIAL_POINTS_PER_ELEMENT is missing"],
        ),
        (
            "density below zero",
            |s| s.replace(MATERIALS, "1000.0", "-1000.0"),
            &["ParticleMaterials.json:10:28 at /properties/0/Material/Variables/DENSITY", "DENSITY is -1000", "> 0"],
        ),
        ("no mass", |s| s.replace(MATERIALS, "1000.0", "0.0"), &["DENSITY is 0", "> 0"]),
        (
            "no stiffness",
            |s| s.replace(MATERIALS, "1e6", "0"),
            &["at /properties/0/Material/Variables/YOUNG_MODULUS", "YOUNG_MODULUS is 0", "> 0"],
        ),
        ("negative modulus", |s| s.replace(MATERIALS, "1e6", "-1e6"), &["YOUNG_MODULUS is -1000000"]),
        (
            "incompressible",
            |s| s.replace(MATERIALS, "0.3", "0.5"),
            &["at /properties/0/Material/Variables/POISSON_RATIO", "POISSON_RATIO is 0.5", "> -1 and < 0.5"],
        ),
        ("ratio 0.7", |s| s.replace(MATERIALS, "0.3", "0.7"), &["POISSON_RATIO is 0.7", "> -1 and < 0.5"]),
        (
            "no thickness left",
            |s| s.replace(MATERIALS, "\"THICKNESS\": 1.0", "\"THICKNESS\": 0.0"),
            &["at /properties/0/Material/Variables/THICKNESS", "THICKNESS is 0, must be a number above 0"],
        ),
        (
            "five points",
            |s| s.replace(MATERIALS, "ELEMENT\": 4", "ELEMENT\": 5"),
            &[
                "at /properties/0/Material/Variables/MATERIAL_POINTS_PER_ELEMENT",
                "MATERIAL_POINTS_PER_ELEMENT is 5",
                "allowed: 1, 4, 9, 16",
            ],
        ),
        (
            "half a point",
            |s| s.replace(MATERIALS, "ELEMENT\": 4", "ELEMENT\": 0.5"),
            &["MATERIAL_POINTS_PER_ELEMENT is 0.5"],
        ),
        (
            "a text",
            |s| s.replace(MATERIALS, "1000.0", "\"heavy\""),
            &["at /properties/0/Material/Variables/DENSITY", "is the text \"heavy\", must be a number"],
        ),
    ]);
}

#[test]
fn all_faults_of_the_materials_come_together() {
    refuse(&[
        (
            "one material",
            |s| {
                s.replace(MATERIALS, "1000.0", "-1.0")
                    .replace(MATERIALS, "1e6", "0")
                    .replace(MATERIALS, "0.3", "0.5")
                    .replace(MATERIALS, "\"THICKNESS\": 1.0,", "")
            },
            &[
                "DENSITY is -1",
                "YOUNG_MODULUS is 0",
                "POISSON_RATIO is 0.5",
                "THICKNESS is missing",
                "4 errors in the input",
            ],
        ),
        (
            "two materials",
            |s| {
                let text = s.text(MATERIALS);
                let entry = &text[text.find("{\n        \"model").unwrap()..text.rfind(']').unwrap()];
                let other = entry.replace(".Cube", ".Other").replace("_id\": 1", "_id\": 2").replace("0.3", "0.6");
                let both = text.replace(entry, &format!("{}, {other}", entry.replace("1000.0", "0.0")));
                s.write(MATERIALS, both)
                    .append(BODY, "Begin Elements MPMUpdatedLagrangian2D3N\n150 0 101 102 104\nEnd Elements\n")
                    .append(BODY, &part("Other", 101..=102, 150..=150))
            },
            &[
                "at /properties/0/Material/Variables/DENSITY",
                "at /properties/1/Material/Variables/POISSON_RATIO",
                "at /properties/1/Material/Variables/MATERIAL_POINTS_PER_ELEMENT",
                "3 errors in the input",
            ],
        ),
    ]);
}

#[test]
fn null_stands_for_no_tables() {
    let outcome =
        Scene::base().replace(MATERIALS, "\"Variables\"", "\"Tables\": null, \"Variables\"").command("check", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn the_old_name_of_the_number_of_points_is_accepted() {
    let outcome = Scene::base().replace(MATERIALS, "MATERIAL_POINTS_PER_ELEMENT", "PARTICLES_PER_ELEMENT").run(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("16 points"), "{}", outcome.stdout);
}
