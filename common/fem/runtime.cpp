#include "common/fem/runtime.h"

#include <deal.II/base/multithread_info.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/lac/trilinos_vector.h>
#include <deal.II/lac/vector_memory.h>

#include <p4est_base.h>
#include <sc.h>

namespace heartbus::fem {

Runtime::Runtime(MPI_Comm communicator) {
  dealii::MultithreadInfo::set_thread_limit(1);
  // deal.II's headers reach p4est even where no forest is used; it must know the participant's communicator, not the
  // world.
  sc_init(communicator, 0, 0, nullptr, SC_LP_SILENT);
  p4est_init(nullptr, SC_LP_SILENT);
}

Runtime::~Runtime() {
  dealii::GrowingVectorMemory<dealii::LinearAlgebra::distributed::Vector<double>>::release_unused_memory();
  dealii::GrowingVectorMemory<dealii::TrilinosWrappers::MPI::Vector>::release_unused_memory();
  dealii::GrowingVectorMemory<dealii::Vector<double>>::release_unused_memory();
  sc_finalize();
}

} // namespace heartbus::fem
