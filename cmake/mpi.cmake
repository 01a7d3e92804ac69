# thrum-mpi: precompute by several processes, on PETSc and SLEPc (mpi/README.md)
find_package(MPI REQUIRED COMPONENTS C)
pkg_check_modules(SLEPC REQUIRED IMPORTED_TARGET slepc>=3.18 petsc>=3.18)
# Debian's .pc file hands on the flags of its own build, which ours are not
set_property(TARGET PkgConfig::SLEPC PROPERTY INTERFACE_COMPILE_OPTIONS)

thrum_add_library(thrum_shared SOURCES mpi/body_*.c mpi/block_*.c mpi/multigrid.c mpi/agreement.c mpi/petsc_status.c mpi/solver_choice.c mpi/shared_precompute.c
  mpi/shared_system.c mpi/inertia_factor.c
  PUBLIC thrum_precompute PkgConfig::SLEPC MPI::MPI_C)
add_executable(thrum_mpi mpi/thrum_mpi.c app/cmd_precompute.c app/cmd_simulate.c app/cmd_static.c app/mpi_program.c app/program_guard.c
  app/address_space.c)
set_target_properties(thrum_mpi PROPERTIES OUTPUT_NAME thrum-mpi)
target_compile_definitions(thrum_mpi PRIVATE _POSIX_C_SOURCE=200809L)
target_link_libraries(thrum_mpi PRIVATE thrum_flags thrum_hardened thrum_driver thrum_shared)
install(TARGETS thrum_mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
