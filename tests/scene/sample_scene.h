#pragma once

#include "common/scene/scene.h"

namespace lumenfarm::test {

/// A small valid scene that uses every kind of element: two surfaces, a texture, glass, three lights, a camera.
inline Scene sample_scene() {
    Scene scene;
    scene.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
    scene.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5f, 0.5f}};
    scene.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 1, 4}};
    scene.surfaces = {{"floor", "room", 0, 2, 0}, {"pane", "window", 2, 1, 1}};
    Spectrum half, index, light;
    half.samples.fill(0.5f);
    index.samples.fill(1.5f);
    light.samples.fill(2.0f);
    scene.spectra = {half, index, light};
    Material floor;
    floor.name = "paint";
    floor.diffuse = {0, 0};
    floor.mirror = {0, none};
    Material pane;
    pane.name = "glass";
    pane.dielectric = 1;
    pane.refractive_index = 1;
    pane.thin = true;
    scene.materials = {floor, pane};
    Texture texture;
    texture.width = 2;
    texture.height = 1;
    texture.wrap_v = Wrap::clamp;
    texture.texels = {{0, 0, 1}, {0.5f, -1, 0}};
    scene.textures = {texture};
    Light lamp;
    lamp.name = "lamp";
    lamp.spectrum = 2;
    lamp.photometric = 1000;
    lamp.surface = 0;
    Light point = lamp;
    point.kind = LightKind::point;
    point.surface = none;
    point.position = {0, 0, 3};
    point.lambertian = true;
    Light spot = point;
    spot.kind = LightKind::spot;
    spot.lambertian = false;
    spot.cos_inner = 0.9;
    spot.cos_outer = 0.8;
    scene.lights = {lamp, point, spot};
    Camera camera;
    camera.name = "camera";
    camera.position = {0, 0, 5};
    scene.cameras = {camera};
    return scene;
}

}  // namespace lumenfarm::test
