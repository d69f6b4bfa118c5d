// Median step time of every cell, with nothing but HDF5: h5c++ -std=c++20 read.cc && ./a.out OUT.h5
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

int main(int, char** argv) {
  const hid_t file = H5Fopen(argv[1], H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, "duration", H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  hsize_t shape[32];  // axes…, rep, phase, cycle
  const hsize_t* last = shape + H5Sget_simple_extent_dims(space, shape, nullptr);
  std::vector<double> all(H5Sget_simple_extent_npoints(space));
  if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0) return 1;
  const hsize_t reps = last[-3], cycles = last[-1], step = 5,
                cells = all.size() / (reps * 6 * cycles);
  for (hsize_t cell = 0; cell < cells; ++cell) {
    std::vector<double> ns;
    for (hsize_t i = 0; i < reps * cycles; ++i)
      ns.push_back(all[((cell * reps + i / cycles) * 6 + step) * cycles + i % cycles]);
    std::erase_if(ns, [](double x) { return std::isnan(x); });
    std::ranges::sort(ns);
    if (size_t n = ns.size()) printf("%d\t%.15g\n", int(cell), (ns[(n - 1) / 2] + ns[n / 2]) / 2);
  }
}
