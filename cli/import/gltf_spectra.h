#pragma once

#include "common/spectrum/spectrum.h"
#include "common/support/result.h"

#include <tiny_gltf.h>

#include <optional>

/// Our extension of glTF (docs/scenes.md): spectra in `extras.lumenfarm_spectra` of a material or a light.
namespace lumenfarm::import {

struct GivenSpectra {
    std::optional<Spectrum> diffuse, mirror, transmission;  ///< in [0, 1]
    std::optional<Spectrum> emission;                       ///< relative, >= 0, not zero everywhere
    std::optional<Spectrum> refractive_index;               ///< >= 1
    std::optional<double> luminance_cd_m2;
    bool lambertian = false;  ///< "distribution": "lambertian" of a point light
};

/// Reads `extras`. Errors: bad_input; the sentence names the member.
Result<GivenSpectra> read_given_spectra(const tinygltf::Value& extras);

}  // namespace lumenfarm::import
