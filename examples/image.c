/* The same as image.cpp, in C: image_c SCENE.glb OUT.exr|OUT.png */
#include <sheen/sheen_c.h>
#include <stdio.h>

int main(int argc, char** argv) {
    const sheen_option options[] = {{"size", "96x96"}, {"accuracy", "1"}};
    sheen_scene* scene = NULL;
    sheen_session* session = NULL;
    sheen_frame* frame = NULL;
    sheen_error error;
    if (argc != 3) {
        fprintf(stderr, "usage: image_c SCENE.glb OUT.exr|OUT.png\n");
        return 2;
    }
    if (sheen_scene_load(argv[1], NULL, 0, NULL, &scene, &error) == SHEEN_DONE &&
        sheen_session_new(scene, &session, &error) == SHEEN_DONE &&
        sheen_render(session, options, 2, NULL, &frame, &error) == SHEEN_DONE &&
        sheen_frame_write(frame, argv[2], NULL, 0, &error) == SHEEN_DONE) {
        printf("wrote %s\n", argv[2]);
    } else {
        fprintf(stderr, "%s\n", error.message);
    }
    sheen_frame_free(frame);
    sheen_session_free(session);
    sheen_scene_free(scene);
    return error.status;
}
