/* The C interface of libsheen, which the C++ header (sheen.h) and the Python module stand on: the
 * only symbols that the library exports.
 *
 * - A function that can fail returns a status and, where `error` is not NULL, fills it; what it was
 *   to make is then NULL. Nothing is printed, ever.
 * - Objects are freed by their _free(), in any order, NULL allowed: a session keeps its scene.
 * - Scenes and frames never change: any thread may use them. A session renders one frame at a time;
 *   other threads wait for it.
 * - Space and units: docs/conventions.md. Options: docs/library.md.
 */
#ifndef SHEEN_C_H
#define SHEEN_C_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SHEEN_API __attribute__((visibility("default")))

/* A caller's number may be none of an enum's, which C++ allows where its type is fixed. */
#ifdef __cplusplus
#define SHEEN_IS_INT : int
#else
#define SHEEN_IS_INT
#endif

/** What became of a call; 0 to 4 are the program's exit codes. */
typedef enum sheen_status {
    SHEEN_DONE = 0,
    SHEEN_BUG = 1,         /**< of the library */
    SHEEN_USAGE = 2,       /**< an option or argument that cannot be, or does not go together */
    SHEEN_INPUT = 3,       /**< a file or an array is missing, damaged or not supported */
    SHEEN_ENVIRONMENT = 4, /**< no OpenGL, no memory, no space, a file that cannot be written */
    SHEEN_CANCELLED = 5    /**< the listener said so */
} sheen_status;

/** Why a call failed: one line, where, what and how to mend it; UTF-8, cut to the buffer. */
typedef struct sheen_error {
    sheen_status status;
    char message[1024];
} sheen_error;

/** A setting, by the name that the program's long option has without its dashes ("accuracy",
 * "0.5"). An empty value is the default. */
typedef struct sheen_option {
    const char* name;
    const char* value;
} sheen_option;

/** Who hears of a call. Each may be NULL. `progress`: of what is under way and the share of it that
 * is done, from any thread, one at a time; another result than 0 cancels the call. `warning`: one
 * line, on the calling thread. */
typedef struct sheen_listener {
    int (*progress)(void* user, const char* what, double done);
    void (*warning)(void* user, const char* message);
    void* user;
} sheen_listener;

typedef struct sheen_scene sheen_scene;
typedef struct sheen_session sheen_session;
typedef struct sheen_frame sheen_frame;

/** Such as "0.2.0". */
SHEEN_API const char* sheen_version(void);

/* ---- Scenes that are handed over as arrays --------------------------------------------------- */

/** [height][width][4]: red, green, blue and alpha, the first row on top. */
typedef struct sheen_image {
    int width, height;
    const uint8_t* rgba;
} sheen_image;

/** glTF's metallic-roughness material. Images may be NULL; they multiply what stands beside them.
 */
typedef struct sheen_material {
    const char* name;                            /**< may be NULL */
    float base_color[3];                         /**< linear Rec. 709, [0, 1] */
    float metallic, roughness;                   /**< [0, 1] */
    float emission[3];                           /**< nits */
    const sheen_image* color_image;              /**< sRGB; its alpha is not looked at */
    const sheen_image* metallic_roughness_image; /**< linear: green roughness, blue metallic */
    const sheen_image* normal_image;             /**< tangent space, linear */
    const sheen_image* emission_image;           /**< sRGB */
    int single_sided;                            /**< cameras look through its back */
} sheen_material;

/** Triangles in world space, counter-clockwise from their front. */
typedef struct sheen_mesh {
    const char* name; /**< may be NULL */
    size_t vertex_count;
    const float* positions; /**< [vertex][3] */
    const float* normals;   /**< [vertex][3]; NULL: each triangle is flat */
    const float* uvs;       /**< [vertex][2], (0, 0) an image's first texel; NULL: none */
    size_t triangle_count;
    const uint32_t* indices; /**< [triangle][3]; NULL: three vertices each, in their order */
    int material;            /**< index; -1: white, diffuse */
} sheen_mesh;

typedef enum sheen_light_kind SHEEN_IS_INT {
    SHEEN_POINT_LIGHT = 0,
    SHEEN_SPOT_LIGHT = 1,
    SHEEN_DIRECTIONAL_LIGHT = 2
} sheen_light_kind;
#undef SHEEN_IS_INT

typedef struct sheen_light {
    sheen_light_kind kind;
    float position[3];            /**< not of a directional one */
    float direction[3];           /**< along which it shines, any length; not of a point light */
    float intensity[3];           /**< candela; of a directional light lux */
    float inner_cone, outer_cone; /**< half angles of a spot, radians; outer: at most pi / 2 */
} sheen_light;

typedef struct sheen_camera {
    const char* name; /**< may be NULL */
    float position[3];
    float look_at[3];
    float up[3]; /**< zero: +y */
    float fov;   /**< vertical, degrees */
} sheen_camera;

/** A scene; each array may be NULL where its count is 0. Copied: none is needed after the call. */
typedef struct sheen_arrays {
    const sheen_material* materials;
    size_t material_count;
    const sheen_mesh* meshes;
    size_t mesh_count;
    const sheen_light* lights;
    size_t light_count;
    const sheen_camera* cameras;
    size_t camera_count;
} sheen_arrays;

/* ---- Scenes ---------------------------------------------------------------------------------- */

/** Loads a .glb or .gltf file. Options: variant, environment, environment-rotation,
 * environment-strength, transparent, and camera, camera-at, look-at, fov, by which it is chosen
 * where world space begins (docs/conventions.md): needed only far from the file's origin. */
SHEEN_API sheen_status sheen_scene_load(const char* path, const sheen_option* options,
                                        size_t option_count, const sheen_listener* listener,
                                        sheen_scene** scene, sheen_error* error);

/** The same of a file's bytes; files that it names are looked for in the current folder. */
SHEEN_API sheen_status sheen_scene_from_bytes(const void* bytes, size_t size,
                                              const sheen_option* options, size_t option_count,
                                              const sheen_listener* listener, sheen_scene** scene,
                                              sheen_error* error);

/** The same of arrays. Without a camera it gets one that frames it, without any light a studio, as
 * a file does. */
SHEEN_API sheen_status sheen_scene_from_arrays(const sheen_arrays* arrays,
                                               const sheen_option* options, size_t option_count,
                                               const sheen_listener* listener, sheen_scene** scene,
                                               sheen_error* error);
SHEEN_API void sheen_scene_free(sheen_scene* scene);

SHEEN_API size_t sheen_scene_triangle_count(const sheen_scene* scene);
SHEEN_API size_t sheen_scene_camera_count(const sheen_scene* scene);
/** NULL beyond the last; valid as long as the scene. */
SHEEN_API const char* sheen_scene_camera_name(const sheen_scene* scene, size_t camera);
/** In the file's coordinates: the least of x, y, z, then the greatest; 1 where there is nothing,
 * else 0. */
SHEEN_API int sheen_scene_bounds(const sheen_scene* scene, double bounds[6]);

/* ---- Rendering ------------------------------------------------------------------------------- */

/** What frames of a scene share: it is made by the first and kept. */
SHEEN_API sheen_status sheen_session_new(const sheen_scene* scene, sheen_session** session,
                                         sheen_error* error);
/** From now on a frame begins with those records of former ones that it sees, and gathers only what
 * is missing: finer images of a view, and views near it, come sooner. A frame then depends, within
 * its error, on those before it. Called again, it begins anew. */
SHEEN_API sheen_status sheen_session_keep_records(sheen_session* session, sheen_error* error);
SHEEN_API void sheen_session_free(sheen_session* session);

/** Renders a frame. Options: those of `sheen render` but for files and the scene's (above), and
 * width and height, in pixels, for size. A session whose frame failed or was cancelled is good for
 * others. */
SHEEN_API sheen_status sheen_render(sheen_session* session, const sheen_option* options,
                                    size_t option_count, const sheen_listener* listener,
                                    sheen_frame** frame, sheen_error* error);
SHEEN_API void sheen_frame_free(sheen_frame* frame);

/* ---- Light at points ------------------------------------------------------------------------- */

/** Points of surfaces. */
typedef struct sheen_points {
    size_t count;
    const double* positions; /**< [point][3], in the file's coordinates */
    const float* normals;    /**< [point][3], any length: the side whose light is asked for */
    float width; /**< what each stands for: about as far as its neighbours lie. The nearest surface
                  * within it, along the normal, is the one that is meant */
} sheen_points;

/** Irradiance, lux, [point][3], about the surface's normal: straight from lights and lamps, and all
 * other. Each of both may be NULL. It comes from records that lie among the points as they would
 * among a lightmap's texels. NaN where there is no surface, of which a warning tells. Options:
 * accuracy (0.4 unless given), bounces, threads. */
SHEEN_API sheen_status sheen_irradiance(const sheen_scene* scene, const sheen_points* points,
                                        const sheen_option* options, size_t option_count,
                                        const sheen_listener* listener, float* direct,
                                        float* indirect, sheen_error* error);

/* ---- Frames ---------------------------------------------------------------------------------- */

SHEEN_API int sheen_frame_width(const sheen_frame* frame);
SHEEN_API int sheen_frame_height(const sheen_frame* frame);

/** Values of a layer: [height][width][channels], the first row on top; valid as long as the frame.
 * Layers are docs/conventions.md's: `beauty` and `alpha`, `direct`, `indirect`, `depth`, ... */
typedef struct sheen_layer {
    const char* name;
    int channels; /**< 1 or 3 */
    const float* values;
} sheen_layer;

SHEEN_API size_t sheen_frame_layer_count(const sheen_frame* frame);
/** By its number; 1 beyond the last, else 0. */
SHEEN_API int sheen_frame_layer_at(const sheen_frame* frame, size_t index, sheen_layer* layer);
/** By its name; a usage error that lists them where there is none. */
SHEEN_API sheen_status sheen_frame_layer(const sheen_frame* frame, const char* name,
                                         sheen_layer* layer, sheen_error* error);
/** [height][width]: the index of the triangle that is seen, 0xffffffff: none. */
SHEEN_API const uint32_t* sheen_frame_primitive(const sheen_frame* frame);

/** The figures of `sheen render --json`, as JSON; valid as long as the frame. */
SHEEN_API const char* sheen_frame_json(const sheen_frame* frame);
/** One of these that is a number, such as "estimate_high" or "seconds/total"; NaN where it is not
 * known. A usage error where there is none of that name. */
SHEEN_API sheen_status sheen_frame_figure(const sheen_frame* frame, const char* name, double* value,
                                          sheen_error* error);

/** Writes the frame to a file, .exr or .png by its name, which appears whole or not at all. An EXR
 * has the layers that the frame was rendered with ("layers"). Options, of a PNG: exposure, tone,
 * view, ocio (default: what the environment variable OCIO names). */
SHEEN_API sheen_status sheen_frame_write(const sheen_frame* frame, const char* path,
                                         const sheen_option* options, size_t option_count,
                                         sheen_error* error);

#ifdef __cplusplus
}
#endif

#endif
