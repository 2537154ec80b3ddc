#pragma once

#include "common/scene/scene.h"
#include "common/scene/scene_file.h"

/// A floor under a luminous square and a point light: the least scene with two lights of different flux.
namespace lumenfarm::testing {

inline Scene small_scene() {
    Scene scene;
    scene.positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {-1, 2, -1}, {1, 2, -1}, {1, 2, 1}, {-1, 2, 1}};
    scene.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
    scene.spectra = {constant_spectrum(0.5), constant_spectrum(1)};
    Material grey;
    grey.name = "grey";
    grey.diffuse.spectrum = 0;
    scene.materials = {grey};
    scene.surfaces = {{"floor", "room", 0, 2, 0}, {"lamp", "room", 2, 2, 0}};
    Light lamp;
    lamp.name = "lamp";
    lamp.kind = LightKind::surface;
    lamp.spectrum = 1;
    lamp.photometric = 100;
    lamp.surface = 1;
    Light bulb;
    bulb.name = "bulb";
    bulb.kind = LightKind::point;
    bulb.spectrum = 1;
    bulb.photometric = 30;
    bulb.position = {0, 1, 0};
    scene.lights = {lamp, bulb};
    return scene;
}

}  // namespace lumenfarm::testing
