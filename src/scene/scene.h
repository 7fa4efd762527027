// The scene as plain data: arrays of structs, integer indices across, everything in world space,
// whose origin lies where floats follow what the camera sees.
// Every stage reads it; nothing changes it after loading.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/math.h"
#include "scene/environment.h"
#include "scene/material.h"
#include "scene/shared.h"

namespace sheen {

using shared::LightSample;
using shared::PunctualLight;

struct Camera {
    std::string name;
    mat4 world_from_camera{1.0f};  ///< rigid; looks along -z, +y up
    float y_fov = 0.9f;            ///< vertical field of view, radians
    float near = 0.0f;             ///< nothing nearer along the view is seen
    float aspect = 0.0f;           ///< width / height; 0: the image's
    /// Of which larger image that is rendered is a part: where its first pixel lies there, and that
    /// image's size; 0: it is all of it.
    struct Window {
        ivec2 first{0};
        ivec2 whole{0};
    } window = {};

    /// Of an image of that size, or of the larger one that it is a part of.
    ivec2 wholeSize(const ivec2& size) const { return window.whole.x > 0 ? window.whole : size; }
};

struct Scene {
    // Vertices: [vertex]
    std::vector<vec3> positions;
    std::vector<vec3> normals;  ///< unit
    std::vector<vec2> uvs;      ///< zero where the mesh has none
    // Empty where no mesh has them.
    std::vector<vec2> second_uvs;    ///< likewise
    std::vector<vec2> lightmap_uvs;  ///< likewise, of materials' lightmaps
    std::vector<vec4> colors;  ///< linear light and alpha, of 1; white where the mesh has none
    /// Of normal maps (Material::tangentTexture()): unit, along growing u, and in w the sign of the
    /// bitangent; zero where a mesh has no such map.
    std::vector<vec4> tangents;
    // Triangles: [triangle]; never degenerate, all coordinates finite. Counter-clockwise seen from
    // the front; the vertex normals may lie on either side.
    std::vector<uvec3> triangles;
    std::vector<uint32_t> materials_of;  ///< index into materials
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<TextureImage> images;
    std::vector<PunctualLight> lights;
    std::vector<std::string> light_names;
    Environment environment;
    /// Every surface that scatters light has it in a lightmap, by LoadParams::lightmaps. The sky
    /// then lights nothing but what mirrors it, and so do lamps where `lamps_baked`: rays see both.
    bool lightmapped = false;
    bool lamps_baked = false;
    std::vector<Camera> cameras;
    Bounds bounds;
    /// Of world space, in the file's coordinates: not zero where the camera stands far from theirs.
    dvec3 origin{0.0};
    std::vector<std::string> files;  ///< that were read: the scene's own and those it names
    /// A part of glTF that the file uses: "right", or "approximated", "ignored" and how.
    struct Feature {
        std::string name, treatment;
    };
    std::vector<Feature> features;
    std::vector<std::string> warnings;  ///< one line each: what the loader had to leave out or mend

    /// What nodes show, by the names of these or of their meshes.
    struct Object {
        uint32_t first_triangle;  ///< up to the next one's
        std::string name;         ///< "node 3" where the file has none
    };
    std::vector<Object> objects;
    /// Where in the file triangles come from, by LoadParams::sources; else empty.
    struct Source {
        uint32_t first_triangle;  ///< up to the next one's
        int node, primitive;      ///< of the node's mesh
        int instance;             ///< of EXT_mesh_gpu_instancing; else 0
    };
    std::vector<Source> sources;
    /// [triangle]: the primitive's vertices at its corners; w: 1 where the last two were exchanged.
    std::vector<uvec4> source_corners;

    int triangleCount() const { return static_cast<int>(triangles.size()); }
    /// A point of world space in the file's coordinates.
    dvec3 inFile(const vec3& p) const { return dvec3(p) + origin; }
};

/// A view of one's own: what is given, of the camera it begins with.
struct Viewpoint {
    std::optional<dvec3> at, look_at;  ///< in the file's coordinates
    std::optional<float> y_fov;        ///< vertical, radians

    bool given() const { return at || look_at || y_fov; }
};

/// How a file is to be seen.
struct LoadParams {
    /// The camera to be seen by, as findCamera() has it, by which Scene::origin is chosen.
    std::string camera = {};
    /// Becomes the scene's first camera. Moved or turned it is upright, and looks at the scene's
    /// middle if at nothing else.
    Viewpoint view = {};
    std::string variant = {};  ///< of KHR_materials_variants; empty: the materials as they are
    /// The light of the surroundings, of which the file says nothing.
    EnvironmentParams environment = {};
    /// Whether to fill Scene::sources.
    bool sources = false;
    /// Whether surfaces are to be seen by the file's lightmaps: Scene::lightmapped, where it has
    /// them for all that scatter light. Else they are ignored, and a warning says so.
    bool lightmaps = false;
};

/// Loads a .glb or .gltf file: geometry with its transforms, materials with their textures, cameras
/// and lights, as docs/gltf.md lists them. Whatever else the file uses is named in Scene::warnings,
/// or, where the result would be wrong (a required extension, a compressed mesh), is an input
/// error. A scene without cameras gets one that frames it; geometry without lights, none of
/// which emits, gets a studio (scene/defaults.h) about its first camera, and a warning that says
/// so, unless an environment is given or said to be none. Usage error where there is no such camera
/// or variant; see loadEnvironment() for its errors.
Scene loadScene(const std::string& path, const LoadParams& params = {});

/// The camera called `name`, or the one with that index; empty: the first. Usage error if absent.
const Camera& findCamera(const Scene& scene, const std::string& name);

/// Ray through the centre of pixel (x, y) of an image, row 0 on top: origin and unit direction,
/// world space. A camera's own aspect, where it has one and differs from the image's, is ignored:
/// the vertical field of view is kept. The same, bit for bit, of a part of an image as of all of
/// it.
struct CameraRay {
    vec3 origin;
    vec3 direction;
};
CameraRay cameraRay(const Camera& camera, int width, int height, float x, float y);

/// The area of a surface that a pixel of an image of `height` rows shows at `position`, where its
/// unit geometric normal is n_g.
float pixelFootprint(const Camera& camera, int height, const vec3& position, const vec3& n_g);

/// The material at a point of a triangle, `barycentric` weighting its three vertices: textures and
/// all else that varies over the surface applied. `footprint`: the area of the surface that the
/// look stands for (shared::footprintArea()), over which textures are averaged; 0: the point alone,
/// by the images as they are. Every pass asks here.
MaterialParams materialAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                          float footprint = 0.0f);

/// What lies on the surface there, likewise.
Layers layersAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                float footprint = 0.0f);

/// The shading normal at a point, unit, as shared::shadingNormal() has it: `n_g` and `wo` lie on
/// one side. The smooth one, interpolated from the vertices, and those that normal maps make of
/// it, averaged like materialAt()'s: of the surface, and of its coat; the same where there is none.
struct ShadingNormals {
    vec3 smooth, mapped, coat;
};
ShadingNormals normalsAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                         const vec3& n_g, const vec3& wo, float footprint = 0.0f);

/// Whether some point of some surface may be specular (isSpecular()), and reflect so. Texels are
/// looked at, wherever on surfaces they lie.
bool anySpecular(const Scene& scene);
/// Likewise of one material.
bool maybeSpecular(const Scene& scene, const Material& material);

/// What the point emits, nits: the emission of materialAt(), for less.
vec3 emissionAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                float footprint = 0.0f);

/// What a lightmap says of the irradiance of a point's front, lux; the material must have one.
vec3 lightmapAt(const Scene& scene, uint32_t triangle, const vec3& barycentric);

/// Of the point of a triangle nearest to p in its plane, by its vertices, each clamped to 0..1.
vec3 barycentricOf(const Scene& scene, uint32_t triangle, const vec3& p);

/// What share of the light the surface meets at a point, to which it does what its material says;
/// the rest passes. 1 without alpha; by a mask 0 or 1; where it is blended, its alpha.
float coverageAt(const Scene& scene, uint32_t triangle, const vec3& barycentric);

/// What becomes of light that comes to a point of a surface along a ray.
struct Crossing {
    float meets;   ///< its share that the material scatters, coverageAt()
    float chance;  ///< by which a ray is to meet the surface, that meets it or passes
    vec3 passes;   ///< its share that goes on straight, of each channel

    /// What light counts that such a ray finds there, and what it finds behind.
    float weightOfMeeting() const { return chance > 0.0f ? meets / chance : 0.0f; }
    vec3 weightOfPassing() const { return passes / (1.0f - chance); }
};

/// Along a unit direction, from either side. Glass passes what its lobe does not reflect there, in
/// its colour [glTF, KHR_materials_transmission]: of a point alone, no texture is averaged.
Crossing crossingAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                    const vec3& along);

/// The surface of a body of glass, told as it is from outside, as it reflects what comes from
/// within: all but what leaves, at whose angle outside (its cosine) it reflects as much from there.
Brdf fromWithin(const Brdf& outside, float roughness, float cosine);

/// Of all points of a triangle, nits.
vec3 meanEmission(const Scene& scene, uint32_t triangle);

/// How far off a triangle an eye or a ray starts that leaves it at `position`, where its unit
/// normal is n_g, seen from `distance` away: what rounding may put between the point, the triangle
/// as rays meet it and a neighbour that touches it there, times a margin; far below anything
/// visible. Grows with the point's coordinates, with what of the triangle's size lies along its
/// normal (of a plane along the axes, nothing) and with the way the point was seen over; never with
/// the scene. Based on: [PJH23, 6.8].
float surfaceOffset(const Scene& scene, uint32_t triangle, const vec3& position, const vec3& n_g,
                    float distance);

/// Where it starts: at a point of a surface whose unit geometric normal n_g is on the side of the
/// unit direction `toward_viewer`, from where the point is seen (zero: from nowhere). The step
/// toward the viewer keeps the start on the viewer's side of a second surface that touches the
/// first one here.
inline vec3 offSurface(const vec3& position, const vec3& n_g, const vec3& toward_viewer,
                       float offset) {
    return position + offset * (n_g + toward_viewer);
}

/// From a point to the nearest point of a triangle.
float distanceToTriangle(const Scene& scene, uint32_t triangle, const vec3& p);

/// Unit geometric normal by winding.
vec3 geometricNormal(const Scene& scene, int triangle);

}  // namespace sheen
