! A wave of calcium through the wall, in place of electrophysiology.
program wave
  use, intrinsic :: iso_c_binding, only: c_double
  use heartbus
  use mpi
  implicit none
  real(c_double), parameter :: rest = 0.13_c_double, rise = 0.025_c_double, decay = 0.15_c_double ! uM, s, s
  real(c_double) :: velocity = 0.6_c_double, peak = 0.8_c_double                                  ! m/s, uM
  real(c_double), pointer :: calcium(:, :), highest
  real(c_double), allocatable :: mine(:, :), activation(:), t(:)
  type(bus_t) :: bus
  type(order_t) :: order
  type(partner_t) :: wall
  integer :: rank, ranks, n, error

  call bus%join('ep', 'wave')
  call bus%setting('velocity', 'm/s', velocity)
  call bus%setting('peak', 'uM', peak)
  wall = bus%partner('mech', 'tissue')
  call MPI_Comm_rank(bus%communicator(), rank, error)
  call MPI_Comm_size(bus%communicator(), ranks, error)
  n = size(wall%points, 2)
  mine = wall%points(:, n * rank / ranks + 1:n * (rank + 1) / ranks)
  call bus%points('tissue', mine, wall%spacing)
  calcium => bus%output('calcium', 'tissue', 1, 'uM')
  highest => bus%scalar('highest_calcium', 'uM', heartbus_max)

  activation = (mine(3, :) - minval(wall%points(3, :))) / velocity ! from the apex upwards
  do while (bus%next(order))
    if (order%what /= heartbus_solve .and. order%what /= heartbus_load) cycle
    t = max(order%time - activation, 0._c_double)
    calcium(1, :) = rest + (peak - rest) * (1 - exp(-t / rise)) * exp(-t / decay)
    highest = max(maxval(calcium), 0._c_double)
  end do
  call bus%leave()
end program wave
