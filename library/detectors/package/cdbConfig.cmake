# find_package(cdb): the target cdb::detector, to which a shared library with detectors is linked. It is a header,
# cdb/detector.h, and C++20.
include(${CMAKE_CURRENT_LIST_DIR}/cdbTargets.cmake)
