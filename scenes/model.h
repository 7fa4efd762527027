// A scene to be written as binary glTF: what the generators fill. Metres, y up, all values double;
// they are rounded when written, so that the last bits of a maths library do not change a file.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <vector>

namespace sheen::scenes {

using glm::dmat4;
using glm::dquat;
using glm::dvec2;
using glm::dvec3;

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;

/// Triangles, counter-clockwise from the front. Normals and uvs are empty or [vertex].
struct Mesh {
    std::vector<dvec3> positions;
    std::vector<dvec3> normals;
    std::vector<dvec2> uvs;
    std::vector<uint32_t> indices;

    size_t triangleCount() const { return indices.size() / 3; }
    /// Appends another mesh that has the same attributes, moved by `transform` (rigid or mirrored).
    void append(const Mesh& other, const dmat4& transform = dmat4(1.0));
};

struct MaterialSpec {
    std::string name;
    dvec3 base_color{0.8};
    double metallic = 0.0;
    double roughness = 1.0;
    double specular = 1.0;        ///< KHR_materials_specular; 0: purely diffuse
    double specular_color = 1.0;  ///< and its colour, grey: F0 = 0.04 * this
    dvec3 emission{0.0};          ///< nits
    int texture = -1;             ///< index into Model::textures
    int normal_texture = -1;      ///< likewise
};

/// GGX width to glTF roughness.
double roughnessFromAlpha(double alpha);

/// One mesh with one material, shown once or more.
struct Object {
    std::string name;
    Mesh mesh;
    int material = 0;
    std::vector<dmat4> placements{dmat4(1.0)};  ///< rigid
};

struct LightSpec {
    std::string name;
    std::string type;  ///< point, spot or directional
    dvec3 position{0.0};
    dvec3 target{0.0};  ///< where it shines
    dvec3 color{1.0};
    double intensity = 1.0;  ///< candela, or lux
    double inner_cone = 0.0;
    double outer_cone = 0.0;  ///< radians, of a spot
};

struct CameraSpec {
    std::string name;
    dvec3 position{0.0};
    dvec3 target{0.0};
    double y_fov = 0.7;  ///< radians
};

/// How a camera, a light or an object that is shown once moves: places at times, in between by
/// straight lines and by turning about one axis.
struct Motion {
    std::string name;  ///< of what moves
    struct Key {
        double seconds;
        dvec3 position;
        dquat rotation;
    };
    std::vector<Key> keys = {};
};

/// The rotation of a camera or light that looks in a direction, upright.
dquat lookRotation(const dvec3& direction);

struct Model {
    std::vector<Object> objects;
    std::vector<MaterialSpec> materials;
    std::vector<std::vector<uint8_t>> textures;  ///< PNG files
    std::vector<LightSpec> lights;
    std::vector<CameraSpec> cameras;
    std::vector<Motion> motions;  ///< of one animation

    /// Adds a material and returns its index.
    int add(MaterialSpec material);
    void add(std::string name, Mesh mesh, int material,
             std::vector<dmat4> placements = {dmat4(1.0)});
};

/// The bytes of a .glb file. The same model gives the same bytes.
std::vector<uint8_t> encodeGlb(const Model& model);

}  // namespace sheen::scenes
