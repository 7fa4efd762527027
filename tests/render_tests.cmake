sheen_test(render SOURCES render_test.cpp render_test_batches.cpp render_test_gather_road.cpp
           render_test_reference.cpp render_test_stability.cpp
           render_test_session.cpp render_test_animation.cpp render_test_crop.cpp render_test_edges.cpp render_test_materials.cpp
           render_test_veils.cpp render_test_glass.cpp render_test_refraction.cpp render_test_caustics.cpp render_test_closed_forms.cpp
           render_test_record_file.cpp render_test_live.cpp
           USES sheen_render sheen_metrics sheen_stress)
# Each file has scenes and sizes of its own by the same names.
set_target_properties(render_test PROPERTIES UNITY_BUILD OFF)
