# The programs, scenes and tools, beside libheartbus (api/CMakeLists.txt). share/heartbus is laid out like this folder, so that
# tools find the scenes.
include(GNUInstallDirs)

install(TARGETS coupler ep_solver mech_solver ale_solver fluid_solver fsi_solver cavity_solver replay stand_in RUNTIME)
install(DIRECTORY configs examples DESTINATION ${CMAKE_INSTALL_DATADIR}/heartbus PATTERN __pycache__ EXCLUDE)
install(DIRECTORY tools DESTINATION ${CMAKE_INSTALL_DATADIR}/heartbus USE_SOURCE_PERMISSIONS
  PATTERN __pycache__ EXCLUDE PATTERN setup.sh EXCLUDE PATTERN fuzz EXCLUDE)
file(RELATIVE_PATH tools ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/heartbus/tools)
file(CREATE_LINK ${tools}/launch.py ${PROJECT_BINARY_DIR}/heartbus-run SYMBOLIC)
file(CREATE_LINK ${tools}/check.py ${PROJECT_BINARY_DIR}/heartbus-check SYMBOLIC)
file(CREATE_LINK ${tools}/heartbus ${PROJECT_BINARY_DIR}/heartbus SYMBOLIC)
install(FILES ${PROJECT_BINARY_DIR}/heartbus-run ${PROJECT_BINARY_DIR}/heartbus-check ${PROJECT_BINARY_DIR}/heartbus TYPE BIN)
install(FILES tools/completion.sh DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME heartbus)

set(CPACK_PACKAGE_NAME heartbus)
set(CPACK_PACKAGE_CONTACT "heartbus")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Cardiac electro-fluid-structure interaction from separate programs")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "openmpi-bin, python3, python3-numpy, python3-yaml")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3-mpi4py, python3-h5py, python3-matplotlib, python3-pil, python3-vtk9, xvfb")
include(CPack)
