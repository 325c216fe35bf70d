//! The C functions against the standard's headers, as bindgen reads them for the crate `fmi`.

use camdrive::fmi2::{abi, functions};
use fmi::fmi2::binding;
use std::mem::{offset_of, size_of};

/// Assigns each function to the header's type of its pointer: a wrong signature does not compile.
macro_rules! signatures {
    ($($function:ident: $type:ident,)*) => {
        #[test]
        fn signatures_are_those_of_the_headers() {
            $(let _: binding::$type = Some(functions::$function);)*
            let names = [$(stringify!($function)),*];
            assert_eq!(names.len(), 42, "all 44 of fmi2Functions.h but two that take structs");
        }
    };
}

signatures! {
    fmi2GetTypesPlatform: fmi2GetTypesPlatformTYPE,
    fmi2GetVersion: fmi2GetVersionTYPE,
    fmi2SetDebugLogging: fmi2SetDebugLoggingTYPE,
    fmi2FreeInstance: fmi2FreeInstanceTYPE,
    fmi2SetupExperiment: fmi2SetupExperimentTYPE,
    fmi2EnterInitializationMode: fmi2EnterInitializationModeTYPE,
    fmi2ExitInitializationMode: fmi2ExitInitializationModeTYPE,
    fmi2Terminate: fmi2TerminateTYPE,
    fmi2Reset: fmi2ResetTYPE,
    fmi2GetReal: fmi2GetRealTYPE,
    fmi2GetInteger: fmi2GetIntegerTYPE,
    fmi2GetBoolean: fmi2GetBooleanTYPE,
    fmi2GetString: fmi2GetStringTYPE,
    fmi2SetReal: fmi2SetRealTYPE,
    fmi2SetInteger: fmi2SetIntegerTYPE,
    fmi2SetBoolean: fmi2SetBooleanTYPE,
    fmi2SetString: fmi2SetStringTYPE,
    fmi2GetFMUstate: fmi2GetFMUstateTYPE,
    fmi2SetFMUstate: fmi2SetFMUstateTYPE,
    fmi2FreeFMUstate: fmi2FreeFMUstateTYPE,
    fmi2SerializedFMUstateSize: fmi2SerializedFMUstateSizeTYPE,
    fmi2SerializeFMUstate: fmi2SerializeFMUstateTYPE,
    fmi2DeSerializeFMUstate: fmi2DeSerializeFMUstateTYPE,
    fmi2GetDirectionalDerivative: fmi2GetDirectionalDerivativeTYPE,
    fmi2EnterEventMode: fmi2EnterEventModeTYPE,
    fmi2EnterContinuousTimeMode: fmi2EnterContinuousTimeModeTYPE,
    fmi2CompletedIntegratorStep: fmi2CompletedIntegratorStepTYPE,
    fmi2SetTime: fmi2SetTimeTYPE,
    fmi2SetContinuousStates: fmi2SetContinuousStatesTYPE,
    fmi2GetDerivatives: fmi2GetDerivativesTYPE,
    fmi2GetEventIndicators: fmi2GetEventIndicatorsTYPE,
    fmi2GetContinuousStates: fmi2GetContinuousStatesTYPE,
    fmi2GetNominalsOfContinuousStates: fmi2GetNominalsOfContinuousStatesTYPE,
    fmi2SetRealInputDerivatives: fmi2SetRealInputDerivativesTYPE,
    fmi2GetRealOutputDerivatives: fmi2GetRealOutputDerivativesTYPE,
    fmi2DoStep: fmi2DoStepTYPE,
    fmi2CancelStep: fmi2CancelStepTYPE,
    fmi2GetStatus: fmi2GetStatusTYPE,
    fmi2GetRealStatus: fmi2GetRealStatusTYPE,
    fmi2GetIntegerStatus: fmi2GetIntegerStatusTYPE,
    fmi2GetBooleanStatus: fmi2GetBooleanStatusTYPE,
    fmi2GetStringStatus: fmi2GetStringStatusTYPE,
}

#[test]
fn constants_and_structs_are_those_of_the_headers() {
    assert_eq!(abi::OK, binding::fmi2Status_fmi2OK);
    assert_eq!(abi::WARNING, binding::fmi2Status_fmi2Warning);
    assert_eq!(abi::DISCARD, binding::fmi2Status_fmi2Discard);
    assert_eq!(abi::ERROR, binding::fmi2Status_fmi2Error);
    assert_eq!(abi::FATAL, binding::fmi2Status_fmi2Fatal);
    assert_eq!(abi::CO_SIMULATION, binding::fmi2Type_fmi2CoSimulation);
    assert_eq!(abi::DO_STEP_STATUS, binding::fmi2StatusKind_fmi2DoStepStatus);
    assert_eq!(abi::PENDING_STATUS, binding::fmi2StatusKind_fmi2PendingStatus);
    assert_eq!(abi::LAST_SUCCESSFUL_TIME, binding::fmi2StatusKind_fmi2LastSuccessfulTime);
    assert_eq!(abi::TERMINATED, binding::fmi2StatusKind_fmi2Terminated);
    assert_eq!(
        [abi::FALSE, abi::TRUE],
        [binding::fmi2False as abi::fmi2Boolean, binding::fmi2True as abi::fmi2Boolean]
    );

    assert_eq!(size_of::<abi::fmi2EventInfo>(), size_of::<binding::fmi2EventInfo>());
    assert_eq!(size_of::<abi::fmi2CallbackFunctions>(), size_of::<binding::fmi2CallbackFunctions>());
    macro_rules! same_place {
        ($($field:ident)*) => {
            $(assert_eq!(
                offset_of!(abi::fmi2CallbackFunctions, $field),
                offset_of!(binding::fmi2CallbackFunctions, $field),
            );)*
        };
    }
    same_place!(logger allocateMemory freeMemory stepFinished componentEnvironment);
}

/// Two functions take structs, whose types have another name here; the rest of their signatures is compared.
#[test]
fn functions_with_structs_differ_from_the_headers_only_in_the_name_of_the_struct() {
    type Instantiate<Callbacks> = unsafe extern "C" fn(
        binding::fmi2String,
        binding::fmi2Type,
        binding::fmi2String,
        binding::fmi2String,
        *const Callbacks,
        binding::fmi2Boolean,
        binding::fmi2Boolean,
    ) -> binding::fmi2Component;
    let _: Instantiate<abi::fmi2CallbackFunctions> = functions::fmi2Instantiate;
    let header: binding::fmi2InstantiateTYPE = None;
    let _: Option<Instantiate<binding::fmi2CallbackFunctions>> = header;

    type NewDiscreteStates<Info> = unsafe extern "C" fn(binding::fmi2Component, *mut Info) -> binding::fmi2Status;
    let _: NewDiscreteStates<abi::fmi2EventInfo> = functions::fmi2NewDiscreteStates;
    let header: binding::fmi2NewDiscreteStatesTYPE = None;
    let _: Option<NewDiscreteStates<binding::fmi2EventInfo>> = header;
}
