//! Which function may be called in which state: the table of FMI 2.0, section 4.2.4, as data.
//!
//! Steps are synchronous and never discarded, so the table's columns "step in progress", "step failed" and "step cancelled" do not
//! occur. Neither does fatal: instances share nothing that one of them could corrupt.

use serde::{Deserialize, Serialize};

/// The state of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mode {
    /// After fmi2Instantiate or fmi2Reset.
    Instantiated,
    /// Between fmi2EnterInitializationMode and fmi2ExitInitializationMode.
    Initialization,
    /// At a communication point.
    StepComplete,
    /// After fmi2Terminate.
    Terminated,
    /// After a failed step; reading values serves for debugging only.
    Error,
}

impl Mode {
    /// The name of the mode in messages.
    pub fn name(self) -> &'static str {
        match self {
            Mode::Instantiated => "instantiated",
            Mode::Initialization => "initialization mode",
            Mode::StepComplete => "step complete",
            Mode::Terminated => "terminated",
            Mode::Error => "error",
        }
    }
}

/// A function of the standard.
#[derive(Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name in fmi2Functions.h.
    pub name: &'static str,
    /// Whether it may be called, in the order of [`Mode`].
    pub allowed: [bool; 5],
}

impl Function {
    /// Whether the function may be called in `mode`.
    pub fn is_allowed_in(&self, mode: Mode) -> bool {
        self.allowed[mode as usize]
    }
}

macro_rules! table {
    ($($constant:ident $name:ident [$($mark:ident)*])*) => {
        $(
            #[doc = concat!("The row of ", stringify!($name), ".")]
            pub const $constant: Function = Function { name: stringify!($name), allowed: [$($mark),*] };
        )*
        /// All rows.
        pub const FUNCTIONS: &[Function] = &[$($constant),*];
    };
}

const X: bool = true;
#[allow(non_upper_case_globals)]
const o: bool = false;

// Columns: instantiated, initialization mode, step complete, terminated, error.
table! {
    SET_DEBUG_LOGGING            fmi2SetDebugLogging               [X X X X X]
    SETUP_EXPERIMENT             fmi2SetupExperiment               [X o o o o]
    ENTER_INITIALIZATION_MODE    fmi2EnterInitializationMode       [X o o o o]
    EXIT_INITIALIZATION_MODE     fmi2ExitInitializationMode        [o X o o o]
    TERMINATE                    fmi2Terminate                     [o o X o o]
    RESET                        fmi2Reset                         [X X X X X]
    GET_REAL                     fmi2GetReal                       [o X X X X]
    GET_INTEGER                  fmi2GetInteger                    [o X X X X]
    GET_BOOLEAN                  fmi2GetBoolean                    [o X X X X]
    GET_STRING                   fmi2GetString                     [o X X X X]
    SET_REAL                     fmi2SetReal                       [X X X o o]
    SET_INTEGER                  fmi2SetInteger                    [X X X o o]
    SET_BOOLEAN                  fmi2SetBoolean                    [X X X o o]
    SET_STRING                   fmi2SetString                     [X X X o o]
    GET_FMU_STATE                fmi2GetFMUstate                   [X X X X X]
    SET_FMU_STATE                fmi2SetFMUstate                   [X X X X X]
    FREE_FMU_STATE               fmi2FreeFMUstate                  [X X X X X]
    SERIALIZED_FMU_STATE_SIZE    fmi2SerializedFMUstateSize        [X X X X X]
    SERIALIZE_FMU_STATE          fmi2SerializeFMUstate             [X X X X X]
    DE_SERIALIZE_FMU_STATE       fmi2DeSerializeFMUstate           [X X X X X]
    GET_DIRECTIONAL_DERIVATIVE   fmi2GetDirectionalDerivative      [o X X X X]
    SET_REAL_INPUT_DERIVATIVES   fmi2SetRealInputDerivatives       [X X X o o]
    GET_REAL_OUTPUT_DERIVATIVES  fmi2GetRealOutputDerivatives      [o o X X X]
    DO_STEP                      fmi2DoStep                        [o o X o o]
    // A step is never in progress when an importer can call.
    CANCEL_STEP                  fmi2CancelStep                    [o o o o o]
    GET_STATUS                   fmi2GetStatus                     [o o X X o]
    GET_REAL_STATUS              fmi2GetRealStatus                 [o o X X o]
    GET_INTEGER_STATUS           fmi2GetIntegerStatus              [o o X X o]
    GET_BOOLEAN_STATUS           fmi2GetBooleanStatus              [o o X X o]
    GET_STRING_STATUS            fmi2GetStringStatus               [o o X X o]
    // The functions of Model Exchange.
    ENTER_EVENT_MODE             fmi2EnterEventMode                [o o o o o]
    NEW_DISCRETE_STATES          fmi2NewDiscreteStates             [o o o o o]
    ENTER_CONTINUOUS_TIME_MODE   fmi2EnterContinuousTimeMode       [o o o o o]
    COMPLETED_INTEGRATOR_STEP    fmi2CompletedIntegratorStep       [o o o o o]
    SET_TIME                     fmi2SetTime                       [o o o o o]
    SET_CONTINUOUS_STATES        fmi2SetContinuousStates           [o o o o o]
    GET_DERIVATIVES              fmi2GetDerivatives                [o o o o o]
    GET_EVENT_INDICATORS         fmi2GetEventIndicators            [o o o o o]
    GET_CONTINUOUS_STATES        fmi2GetContinuousStates           [o o o o o]
    GET_NOMINALS                 fmi2GetNominalsOfContinuousStates [o o o o o]
}
