if(SHEEN_MPI)
    sheen_test(mpi SOURCES mpi_test.cpp USES sheen_scene nlohmann_json::nlohmann_json)
    target_compile_definitions(mpi_test PRIVATE SHEEN_PROGRAM="$<TARGET_FILE:sheen>"
                                                SHEEN_MPI_PROGRAM="$<TARGET_FILE:sheen-mpi>"
                                                SHEEN_MPIRUN="${MPIEXEC_EXECUTABLE}")
    add_dependencies(mpi_test sheen sheen-mpi)
endif()
