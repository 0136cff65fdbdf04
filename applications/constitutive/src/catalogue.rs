//! The laws by the names that stand in materials files.
//!
//! Kratos names a law together with its kinematics; each such name is one [`LawEntry`]. Another
//! crate adds its own: `catalogue.register(LawEntry::of::<MyLaw>("MyLaw3D", &[ThreeDimensional]))`.

use bia_kernel::diagnostic::{Diagnostic, InputErrors, Place};
use bia_kernel::model::Properties;
use bia_kernel::registry::{Description, Kinds, Registry};
use thiserror::Error;

use crate::{
    ConstitutiveLaw, Fault, Kinematics, Law, Material, MaterialVariable, Options, kirchhoff_bar, linear_elastic,
    neo_hookean, neo_hookean_mixed, newtonian, newtonian_mixed, nominal_elastic,
};

/// A law under one name.
#[derive(Debug, Clone, Copy)]
pub struct LawEntry {
    /// Name in materials files.
    pub name: &'static str,
    /// Other names for the same entry.
    pub aliases: &'static [&'static str],
    /// Name of the law itself, which it shares with its entries for other kinematics.
    pub law: &'static str,
    /// Elements that may use it under this name.
    pub kinematics: &'static [Kinematics],
    /// The law in one sentence.
    pub help: &'static str,
    /// The constants that it takes.
    pub variables: &'static [MaterialVariable],
    /// The constants that it takes if they are given.
    pub optional: &'static [MaterialVariable],
    /// The law is for mixed displacement-pressure elements.
    pub mixed: bool,
    /// Makes the law from a material, or lists all the material's faults.
    pub build: Build,
    /// Makes the law that explicit solvers use under this name, if that is another one.
    pub explicit: Option<Build>,
}

/// Makes a law from a material, or lists all the material's faults.
pub type Build = fn(&Properties, &Options) -> Result<Box<dyn Law>, Vec<Fault>>;

impl LawEntry {
    /// The entry of law `L` under `name` for elements of `kinematics`, without aliases.
    pub const fn of<L: ConstitutiveLaw>(name: &'static str, kinematics: &'static [Kinematics]) -> Self {
        Self {
            name,
            aliases: &[],
            law: L::NAME,
            kinematics,
            help: L::HELP,
            variables: L::VARIABLES,
            optional: L::OPTIONAL,
            mixed: L::MIXED,
            build: build::<L>,
            explicit: None,
        }
    }

    /// The same entry with another law, of the same constants, for explicit solvers.
    #[must_use]
    pub const fn explicit<L: ConstitutiveLaw>(self) -> Self {
        Self { explicit: Some(build::<L>), ..self }
    }

    /// The same entry under further names.
    #[must_use]
    pub const fn also(self, aliases: &'static [&'static str]) -> Self {
        Self { aliases, ..self }
    }

    /// Its name and aliases.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.aliases.iter().copied())
    }
}

fn build<L: ConstitutiveLaw>(properties: &Properties, options: &Options) -> Result<Box<dyn Law>, Vec<Fault>> {
    let material = Material::new(properties, options, L::VARIABLES, L::OPTIONAL)?;
    let law = L::new(&material).map_err(|fault| vec![fault])?;
    Ok(Box::new(law))
}

/// A name was registered before.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("a constitutive law named {0} is registered already; give the new one another name")]
pub struct DuplicateLaw(
    /// The name.
    pub &'static str,
);

/// Laws of Kratos's MPMApplication 10.4; those that a catalogue holds are found there first.
const KNOWN_TO_KRATOS: &[&str] = &[
    "HenckyMCPlastic3DLaw",
    "HenckyMCPlasticPlaneStrain2DLaw",
    "HenckyMCPlasticAxisym2DLaw",
    "HenckyMCPlasticUP3DLaw",
    "HenckyMCPlasticPlaneStrainUP2DLaw",
    "HenckyMCStrainSofteningPlastic3DLaw",
    "HenckyMCStrainSofteningPlasticPlaneStrain2DLaw",
    "HenckyMCStrainSofteningPlasticAxisym2DLaw",
    "HenckyBorjaCamClayPlastic3DLaw",
    "HenckyBorjaCamClayPlasticPlaneStrain2DLaw",
    "HenckyBorjaCamClayPlasticAxisym2DLaw",
    "JohnsonCookThermalPlastic3DLaw",
    "JohnsonCookThermalPlastic2DPlaneStrainLaw",
    "JohnsonCookThermalPlastic2DAxisymLaw",
];

/// Where a material's law and its values stand.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MaterialPlaces {
    /// The name of the law.
    pub law: Place,
    /// The object of constants.
    pub values: Place,
}

/// The laws that a run may name, in the order of their registration.
#[derive(Debug, Clone, Default)]
pub struct Catalogue {
    entries: Vec<LawEntry>,
}

/// The laws of this crate; a new law adds its line here.
pub fn catalogue() -> Catalogue {
    let entries = [
        linear_elastic::entries(), //
        neo_hookean::entries(),
        neo_hookean_mixed::entries(),
        newtonian::entries(),
        newtonian_mixed::entries(),
        nominal_elastic::entries(),
        kirchhoff_bar::entries(),
    ];
    Catalogue { entries: entries.concat() }
}

/// Adds the laws of this crate to the registry's catalogue; names that are there already are kept.
pub fn register(registry: &mut Registry) {
    let known = registry.catalogue_mut::<Catalogue>();
    let new = catalogue().entries.into_iter().filter(|entry| known.find(entry.name).is_none());
    let new: Vec<LawEntry> = new.collect();
    known.entries.extend(new);
    registry.kind(Kinds { title: "laws", describe });
    crate::solutions::register(registry);
}

/// The laws of the registry's catalogue as a user asks for them.
fn describe(registry: &Registry) -> Vec<Description> {
    let entries = registry.catalogue::<Catalogue>().map_or(&[][..], |catalogue| &catalogue.entries);
    let value = |v: &MaterialVariable| [v.name.into(), v.unit.into(), v.range.to_string(), v.help.into()];
    let of_entry = |entry: &LawEntry| {
        let kinematics: Vec<&str> = entry.kinematics.iter().map(|kind| kind.name()).collect();
        Description {
            name: entry.name.into(),
            aliases: entry.aliases.iter().map(|alias| (*alias).to_string()).collect(),
            help: format!("{} ({})", entry.help, kinematics.join(", ")),
            values: entry.variables.iter().map(value).collect(),
        }
    };
    entries.iter().map(of_entry).collect()
}

impl Catalogue {
    /// Adds a law.
    ///
    /// # Errors
    /// The name, or one of the aliases, is taken.
    pub fn register(&mut self, entry: LawEntry) -> Result<(), DuplicateLaw> {
        if let Some(name) = entry.names().find(|name| self.find(name).is_some()) {
            return Err(DuplicateLaw(name));
        }
        self.entries.push(entry);
        Ok(())
    }

    /// All entries.
    pub fn entries(&self) -> &[LawEntry] {
        &self.entries
    }

    /// The entry of this name or alias. Of a dotted path, such as
    /// `KratosMultiphysics.MPMApplication.Name`, the last part counts.
    pub fn find(&self, name: &str) -> Option<&LawEntry> {
        let last = last_part(name);
        self.entries.iter().find(|entry| entry.names().any(|other| other == last))
    }

    /// The law that `properties` names, for elements of `kinematics`.
    ///
    /// # Errors
    /// No law is named, the name is unknown or belongs to other kinematics, or constants are at
    /// fault: all of these together, as far as they can be judged.
    pub fn build(
        &self,
        properties: &Properties,
        kinematics: Kinematics,
        options: &Options,
        places: &MaterialPlaces,
    ) -> Result<Box<dyn Law>, InputErrors> {
        let entry = self.entry_of(properties, kinematics, &places.law)?;
        let mut errors = InputErrors::default();
        if !entry.kinematics.contains(&kinematics) {
            errors.push(self.wrong_kinematics(entry, kinematics, &places.law));
        }
        if entry.mixed != options.mixed.is_some() {
            errors.push(self.wrong_formulation(entry, kinematics, &places.law));
        }
        let build = entry.explicit.filter(|_| options.explicit).unwrap_or(entry.build);
        let built = build(properties, options)
            .map_err(|faults| InputErrors(faults.iter().map(|fault| fault.diagnostic(&places.values)).collect()));
        match errors.absorb(built) {
            Some(law) if !errors.any_error() => Ok(law),
            _ => Err(errors),
        }
    }

    fn entry_of(
        &self,
        properties: &Properties,
        kinematics: Kinematics,
        place: &Place,
    ) -> Result<&LawEntry, InputErrors> {
        let Some(name) = &properties.law else {
            let message = format!("the material with properties id {} names no constitutive law", properties.id);
            let names = self.names_for(kinematics).join(", ");
            return Err(Diagnostic::error(place.clone(), message)
                .help(format!("laws for {kinematics}: {names}"))
                .into());
        };
        self.find(name).ok_or_else(|| {
            if KNOWN_TO_KRATOS.contains(&last_part(name)) {
                let message = format!("the constitutive law {name:?} is known to Kratos, but not in this build");
                let help = format!("laws for {kinematics}: {}", self.names_for(kinematics).join(", "));
                return Diagnostic::error(place.clone(), message).help(help).into();
            }
            let message = format!("unknown constitutive law {name:?}");
            let names = self.entries.iter().flat_map(LawEntry::names);
            Diagnostic::error(place.clone(), message).allowed(last_part(name), names).into()
        })
    }

    fn wrong_kinematics(&self, entry: &LawEntry, kinematics: Kinematics, place: &Place) -> Diagnostic {
        let made_for: Vec<&str> = entry.kinematics.iter().map(|kind| kind.name()).collect();
        let message = format!(
            "the constitutive law {} is for {} elements, but these elements are {kinematics}",
            entry.name,
            made_for.join(" or ")
        );
        let sibling = self.entries.iter().find(|e| e.law == entry.law && e.kinematics.contains(&kinematics));
        let help = match sibling {
            Some(sibling) => format!("use {}", sibling.name),
            None => format!("laws for {kinematics}: {}", self.names_for(kinematics).join(", ")),
        };
        Diagnostic::error(place.clone(), message).help(help)
    }

    fn wrong_formulation(&self, entry: &LawEntry, kinematics: Kinematics, place: &Place) -> Diagnostic {
        let others = self.entries.iter().filter(|e| e.mixed != entry.mixed && e.kinematics.contains(&kinematics));
        let others: Vec<&str> = others.map(|e| e.name).collect();
        let (message, setting) = match entry.mixed {
            true => ("needs nodal pressures", "set \"pressure_dofs\" to true"),
            false => ("has no nodal pressure", "set \"pressure_dofs\" to false"),
        };
        let message = format!("the constitutive law {} {message}", entry.name);
        Diagnostic::error(place.clone(), message).help(format!("{setting}, or use one of {}", others.join(", ")))
    }

    fn names_for(&self, kinematics: Kinematics) -> Vec<&'static str> {
        self.entries.iter().filter(|e| e.kinematics.contains(&kinematics)).map(|e| e.name).collect()
    }
}

fn last_part(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use bia_kernel::model::Value;

    use super::*;
    use crate::VolumetricLaw;

    fn rubber(law: &str) -> Properties {
        let numbers = [
            ("DENSITY", 1000.0),
            ("YOUNG_MODULUS", 1e6),
            ("POISSON_RATIO", 0.3),
            ("BULK_MODULUS", 1e6),
            ("DYNAMIC_VISCOSITY", 1.0),
        ];
        let values = numbers.map(|(name, number)| (name.to_owned(), Value::Number(number))).into();
        Properties { law: Some(law.into()), values, ..Default::default() }
    }

    fn build(properties: &Properties, kinematics: Kinematics) -> Result<Box<dyn Law>, String> {
        build_for(properties, kinematics, None)
    }

    fn build_for(
        properties: &Properties,
        kinematics: Kinematics,
        mixed: Option<VolumetricLaw>,
    ) -> Result<Box<dyn Law>, String> {
        catalogue()
            .build(properties, kinematics, &Options { mixed, ..Options::default() }, &MaterialPlaces::default())
            .map_err(|errors| errors.to_string())
    }

    #[test]
    fn names_are_unique_and_each_entry_builds_for_its_kinematics() {
        let all = catalogue();
        let mut again = Catalogue::default();
        for entry in all.entries() {
            again.register(*entry).unwrap();
            for &kinematics in entry.kinematics {
                let dotted = format!("KratosMultiphysics.MPMApplication.{}", entry.name);
                let mixed = entry.mixed.then(VolumetricLaw::default);
                let law = build_for(&rubber(&dotted), kinematics, mixed).unwrap();
                assert_eq!((law.name(), law.mixed().is_some()), (entry.law, entry.mixed));
                let other = build_for(&rubber(&dotted), kinematics, (!entry.mixed).then(VolumetricLaw::default));
                assert!(other.is_err_and(|error| error.contains("pressure_dofs")), "{}", entry.name);
            }
        }
        let taken = LawEntry { name: "Other", aliases: &["HyperElasticNeoHookean3DLaw"], ..all.entries()[0] };
        assert_eq!(again.register(taken), Err(DuplicateLaw("HyperElasticNeoHookean3DLaw")));
    }

    #[test]
    fn explicit_solvers_get_the_law_of_accumulated_strain() {
        let properties = rubber("LinearElasticIsotropic3DLaw");
        for explicit in [false, true] {
            let options = Options { explicit, ..Options::default() };
            let law = catalogue()
                .build(&properties, Kinematics::ThreeDimensional, &options, &MaterialPlaces::default())
                .unwrap();
            assert_eq!(law.uses_strain(), explicit);
        }
    }

    #[test]
    fn aliases_find_their_entry() {
        let mut all = catalogue();
        let entry = LawEntry { name: "Rubber", ..all.entries()[0] }.also(&["Gum"]);
        all.register(entry).unwrap();
        assert_eq!(all.find("Some.Gum").map(|entry| entry.name), Some("Rubber"));
    }

    #[test]
    fn unknown_names_get_the_nearest() {
        let error = build(&rubber("HyperElasticNeoHookeanPlainStrain2DLaw"), Kinematics::PlaneStrain).err().unwrap();
        assert!(error.contains("did you mean \"HyperElasticNeoHookeanPlaneStrain2DLaw\""), "{error}");
        let nameless = Properties { law: None, id: 7, ..rubber("") };
        let error = build(&nameless, Kinematics::Axisymmetric).err().unwrap();
        assert!(error.contains("id 7") && error.contains("HyperElasticNeoHookeanAxisym2DLaw"), "{error}");
        assert!(!error.contains("3DLaw"), "{error}");
    }

    #[test]
    fn laws_of_kratos_that_are_not_here_are_told_apart_from_slips() {
        for name in KNOWN_TO_KRATOS.iter().filter(|name| catalogue().find(name).is_none()) {
            let error = build(&rubber(&format!("MPMApplication.{name}")), Kinematics::PlaneStrain).err().unwrap();
            assert!(error.contains("known to Kratos") && error.contains("laws for plane strain"), "{error}");
        }
    }

    #[test]
    fn wrong_kinematics_and_wrong_constants_are_reported_together() {
        let mut material = rubber("HyperElasticNeoHookean3DLaw");
        material.values.remove("DENSITY");
        let error = build(&material, Kinematics::PlaneStrain).err().unwrap();
        assert!(
            error.contains("is for three-dimensional or uniaxial strain elements, but these elements are plane strain"),
            "{error}"
        );
        assert!(error.contains("use HyperElasticNeoHookeanPlaneStrain2DLaw"), "{error}");
        assert!(error.contains("DENSITY is missing"), "{error}");
    }
}
