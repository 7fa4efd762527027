// What the files of the glTF loader share: the parsed file with its checks, and one function for
// each part of a scene. tinygltf parses the JSON; it hands every index, offset and count on as
// written, so each is checked here before it is used.
#pragma once

#include <tiny_gltf.h>

#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "scene/scene.h"

namespace sheen::gltf {

/// Squares of distances up to here are floats.
constexpr double kLargestExtent = 1e18;

/// Things left out or mended, counted by kind, in the order of their first appearance.
class Notes {
  public:
    void add(const std::string& what, int64_t count = 1);
    void add(const Notes& others);
    /// One line each, with its count where it is more than one.
    std::vector<std::string> lines() const;
    /// Those of other kinds than these.
    Notes without(const Notes& known) const;

  private:
    std::vector<std::pair<std::string, int64_t>> notes_;
};

/// Bytes that a file holds or names.
struct FileBytes {
    std::vector<unsigned char> bytes = {};
    std::string missing = {};  ///< why they are not there, and how to mend it; empty: they are
};

/// An image as a file has it.
struct EncodedImage {
    std::string name;
    int buffer_view = -1;  ///< -1: `content` has it
    FileBytes content = {};
};

/// A file being loaded.
struct File {
    std::string path;
    std::string bytes = {};              ///< its content; empty: it is read from `path`
    std::vector<std::string> read = {};  ///< files that `path` names
    tinygltf::Model model;               ///< without buffers, images and animations
    std::vector<FileBytes> buffers = {};
    std::vector<EncodedImage> images = {};
    std::shared_ptr<const nlohmann::json> animations = {};  ///< an array, as it is written
    bool keeps_sources = false;                             ///< LoadParams::sources
    std::string variants = {};                              ///< their names, for messages
    int variant = -1;                                       ///< that is chosen; -1: none
    Notes notes;
    /// Cameras of Scene without perspective, until the scene's size is known.
    struct ParallelCamera {
        size_t camera;
        float half_height, near;
    };
    std::vector<ParallelCamera> parallel_cameras = {};

    /// Throws an input error that names the file: where in it, and what is wrong and how to mend
    /// it.
    template <class... Args>
    [[noreturn]] void fail(const std::string& where, fmt::format_string<Args...> what,
                           Args&&... args) const {
        throwInput("{}: {}: {}", path, where, fmt::format(what, std::forward<Args>(args)...));
    }

    /// `list[index]`, or an input error: `where` refers to "`kind` `index`", which is not there.
    template <class T>
    const T& at(const std::vector<T>& list, int index, const std::string& where,
                const char* kind) const {
        if (index < 0 || static_cast<size_t>(index) >= list.size()) {
            fail(where, "refers to {} {}, but the file has {}; export it again", kind, index,
                 list.size());
        }
        return list[static_cast<size_t>(index)];
    }

    bool uses(const std::string& extension) const;
    bool animated() const;
};

/// Parses `file.bytes`, or reads `file.path`: whole, version 2, with no extension required that is
/// not understood; images stay encoded. Throws input errors.
void parse(File& file);

/// Whether an extension is one that docs/gltf.md lists, right or not: a file may require it.
bool isUnderstood(const std::string& extension);

/// The JSON text of a file that parse() accepted.
std::string jsonOf(const std::string& path);

/// Notes what the file as a whole asks for and does not get: extensions.
void noteIgnoredParts(File& file);

/// Fills Scene::features.
void listFeatures(const File& file, Scene& scene);

/// What a scene has that no node of its file brings: it stays where it is while they move.
struct Additions {
    std::vector<PunctualLight> lights = {};  ///< of a sky's sun, of a studio
    std::vector<std::string> light_names = {};
    std::optional<Camera> camera = {};  ///< of a file without any
    LoadParams params = {};             ///< that look at a point where they look at anything
};

/// Loads all of a scene, as its nodes stand, into `file` and `scene`.
Additions load(File& file, const LoadParams& params, Scene& scene);

/// Brings geometry, lights and cameras of a loaded scene to where the file's nodes stand now; what
/// is to be said of that is in File::notes. Errors as loadScene().
void placeAgain(File& file, const Additions& additions, Scene& scene);

/// Such as "node 3 (lamp)"; the name may be any text.
std::string label(const char* kind, size_t index, const std::string& name);

/// The first of both names that is not empty, else such as "camera 3".
std::string firstName(const std::string& own, const std::string& node, const char* kind,
                      size_t index);

/// Which component types an accessor may have beside float.
enum class Integers { kNo, kNormalizedUnsigned, kAny };

/// Bytes that someone else owns.
struct ByteSpan {
    const unsigned char* data = nullptr;
    size_t size = 0;
};

/// Fills File::buffers from the array of a document; `chunk`: what a .glb holds beside it, if
/// anything. Those that are not there, or cut short, are missing; whoever uses them fails.
void readBuffers(File& file, const nlohmann::json& buffers, ByteSpan chunk);

/// Likewise File::images.
void readImages(File& file, const nlohmann::json& images);

/// Makes of each compressed buffer view one of a buffer of its own; one that cannot be decoded is
/// missing there.
void decompressViews(File& file);

/// Gives the accessors of each Draco-compressed primitive, unless the file holds their numbers
/// besides, buffers of their own. Input error for one that cannot be decoded.
void decompressMeshes(File& file);

/// A part of a buffer, checked against it; `where`: who asks, for errors.
ByteSpan bytesOf(const File& file, int buffer, size_t offset, size_t length,
                 const std::string& where);

/// Bytes of a buffer view, checked against its buffer.
ByteSpan bufferViewBytes(const File& file, int buffer_view, const std::string& where);

/// How many elements an accessor has, or fewer where the file cannot hold them.
uint64_t accessorCount(const File& file, const tinygltf::Accessor& accessor);

/// How many numbers an element of an accessor has: 1 to 4 or 16, 0 where that is something else.
int accessorComponents(const File& file, int accessor, const std::string& where);

/// An accessor's values as floats, [element][components]; `components` is 1 to 4 or, of a matrix
/// by columns, 16. Normalised
/// integers become [0, 1] or [-1, 1]; sparse accessors are filled in.
std::vector<float> readFloats(const File& file, int accessor, int components, Integers integers,
                              const std::string& where);

/// An accessor's numbers as they are stored, sparse ones filled in.
std::vector<double> readNumbers(const File& file, int accessor, const std::string& where);

/// An accessor's values as vertex indices, each below `vertex_count`.
std::vector<uint32_t> readIndices(const File& file, int accessor, size_t vertex_count,
                                  const std::string& where);

/// Likewise an integer, as JSON may have it.
int integerMember(const File& file, const tinygltf::Value& object, const std::string& key,
                  int fallback, const std::string& where);

/// What a material says of one of its textures.
struct TextureInfo {
    int index = -1;  ///< of the file's textures; -1: none
    int uv_set = 0;
    tinygltf::Value transform = {};  ///< KHR_texture_transform, an object where it is used
};
TextureInfo textureInfo(const File& file, const tinygltf::Value& object, const std::string& where);

/// An image of the file; none, with a note that says what its `loss` means, where it cannot be
/// read or a side of it has more texels than `longest`.
std::optional<TextureImage> loadImage(File& file, int index, const char* loss,
                                      int longest = std::numeric_limits<int>::max());

/// Loads a file's textures as materials ask for them, each image once. Whatever is broken about one
/// is noted, and it is left out: it never keeps the file from loading.
class TextureLoader {
  public:
    /// Notes where images are too large together to be kept whole.
    TextureLoader(File& file, Scene& scene);
    /// `owner`: the material, for errors.
    TextureUse use(const TextureInfo& info, bool srgb, const std::string& owner);
    /// Likewise of a lightmap, whose colours are linear light and whose coordinates, of any set,
    /// become Scene::lightmap_uvs.
    TextureUse useLightmap(const TextureInfo& info, const std::string& owner);
    /// The roughness that is left by a texture's alpha times a glossiness, as a texture of its own.
    TextureUse roughnessOf(const TextureUse& gloss, float glossiness);
    /// A texture whose green is mixed from `lower` to `upper`, of at most 1, likewise.
    TextureUse withGreenBetween(const TextureUse& use, float lower, float upper);

  private:
    template <class Read>
    TextureUse unlessBroken(const TextureInfo& info, const Read& read);
    TextureUse placed(const TextureInfo& info, const std::string& owner) const;
    TextureUse usable(const TextureInfo& info, bool srgb, const std::string& owner);
    template <class Green>
    TextureUse remade(const TextureUse& use, const Green& green);
    int load(int index, bool srgb, const std::string& owner);
    File& file_;
    Scene& scene_;
    std::map<int, int> images_;  // of the scene, by the file's; -1: it cannot be read
    int largest_side_;           // of an image as it is kept, texels
};

/// Chooses a variant of the materials by its name; empty: none. Usage error where there is none of
/// that name.
void chooseVariant(File& file, const std::string& name);

/// Index of a primitive's material in the variant that is chosen; -1: it has none.
int materialOf(const File& file, const tinygltf::Primitive& primitive, const std::string& where);

/// All materials of the file, in its order, and the glTF default material behind them, with the
/// textures they use; their lightmaps where these are asked for.
void loadMaterials(File& file, bool lightmaps, Scene& scene);

/// Once meshes are loaded: fills Scene::lightmapped and lamps_baked where lightmaps were asked for
/// and all that scatters light has one; else there are none, and a note says why.
void settleLightmaps(File& file, bool wanted, Scene& scene);

/// Makes opaque what is blended and opaque all over, as exporters write it.
void dropIdleBlending(Scene& scene);

/// Appends what the nodes of the file's scene show: meshes, cameras and lights.
void appendNodes(File& file, Scene& scene);

/// Environment error where the meshes, shown by many nodes each, would take more memory than there
/// is.
void checkMeshMemory(const File& file);

/// Appends a node's camera; `where`: the node, for errors. One without perspective is noted in
/// File::parallel_cameras.
void appendCamera(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                  const std::string& where, Scene& scene);

/// Makes parallel cameras ones of perspective, so far away that what they see hardly converges: it
/// is as large as it should be at the scene's middle. What lay behind them stays unseen.
void placeParallelCameras(File& file, Scene& scene);

/// Appends a node's light; `where`: the node, for errors.
void appendLight(File& file, const tinygltf::Node& node, const glm::dmat4& world_from_node,
                 const std::string& where, Scene& scene);

/// The sky that the file's scene has, by latitude and longitude; empty where it has none, or one
/// that is left out, with a note.
Environment loadSky(File& file);

/// Index of the scene that is shown; -1: the file has no scenes.
int shownScene(const File& file);

/// Input error where all light together is more, or less, than floats can follow: the image would
/// be black, white or not finite.
void checkLightLevel(const File& file, const Scene& scene);

/// How a mesh is shown.
struct Pose {
    glm::dmat4 world_from_mesh;
    std::vector<glm::dmat4> world_from_joint = {};  ///< of a skin, from the mesh; empty: none
    std::vector<double> weights = {};               ///< of morph targets
    int node = -1;                                  ///< whose mesh it is
    int instance = 0;                               ///< of the node
};

/// Appends a mesh, transformed to world space: by its skin where it has one.
void appendMesh(File& file, int mesh, const Pose& pose, Scene& scene);

/// Those of a node's mesh, as stored.
std::vector<double> morphWeights(const File& file, const tinygltf::Node& node);

/// Adds a primitive's morph targets to an attribute's `values`, [vertex][components], the first
/// three of which they move.
void addMorphTargets(const File& file, const tinygltf::Primitive& source, const char* attribute,
                     const std::vector<double>& weights, size_t components, std::span<float> values,
                     const std::string& where);

/// Transforms of a skin's joints where the nodes stand, from the mesh; `where`: the node that is
/// skinned, for errors.
std::vector<glm::dmat4> jointTransforms(const File& file, int skin,
                                        const std::vector<glm::dmat4>& file_from_node,
                                        const std::string& where);

/// Transforms of a primitive's `count` vertices, each a mean of its joints'; none where it has no
/// joints.
std::vector<glm::dmat4> skinnedTransforms(const File& file, const tinygltf::Primitive& source,
                                          const std::vector<glm::dmat4>& joints, size_t count,
                                          const std::string& where);

/// Tangents of the vertices of a mesh's triangles, from `first_triangle` on to the scene's end, by
/// the coordinates of the material's normal texture: each triangle's weighed by its angles, as
/// MikkTSpace does. A vertex where mirrored coordinates meet is made two.
void makeTangents(Scene& scene, size_t first_triangle);

/// Where surfaces of different materials that face one way lie in one plane, the later of them in
/// the file is put in front of the other, and noted. Each would win in places otherwise, others for
/// rays than for rasterisers.
void separateCoplanar(File& file, Scene& scene);

/// A finite float from a JSON number, or an input error.
float finiteFloat(const File& file, double value, const std::string& where, const char* what);

/// Member `key` of an extension object: its number, or `fallback` where it is absent.
double numberMember(const File& file, const tinygltf::Value& object, const std::string& key,
                    double fallback, const std::string& where);

}  // namespace sheen::gltf
