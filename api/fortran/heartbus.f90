!> A program in Fortran takes part in a coupled run of the heart.
!!
!!     use heartbus
!!     type(bus_t) :: bus
!!     type(order_t) :: order
!!     call bus%join('ep', 'my_ep')
!!     ... bus%points, bus%output, bus%input, bus%task, bus%scalar ...
!!     do while (bus%next(order))
!!       if (order%what == heartbus_solve) ...
!!     end do
!!     call bus%leave()
!!
!! Arrays are those that the bus sends from and receives into. All values are in SI units (calcium in uM). Any failure of
!! the launch ends the program at once with the right exit code; the cause has been printed.
module heartbus
  use, intrinsic :: iso_c_binding
  use heartbus_c
  implicit none
  private
  public :: bus_t, order_t, partner_t
  public :: heartbus_end, heartbus_prepare, heartbus_solve, heartbus_commit, heartbus_task, heartbus_save, &
            heartbus_load, heartbus_refresh, heartbus_finish
  public :: heartbus_first, heartbus_min, heartbus_max, heartbus_sum
  public :: heartbus_unforeseen, heartbus_scene, heartbus_handshake, heartbus_map, heartbus_not_converged, &
            heartbus_not_finite, heartbus_deadline, heartbus_file

  type :: order_t
    integer :: what = heartbus_end, number = 0, iteration = 0
    real(c_double) :: time = 0, size = 0 !< [s]
    character(:), allocatable :: text    !< name of the task, or folder of the state
  end type order_t

  !> Points of another participant, (3, n) [m]; faces: numbers of points from 1, (corners, n).
  type :: partner_t
    real(c_double), pointer :: points(:, :) => null()
    real(c_double) :: spacing = 0
    integer, allocatable :: faces(:, :)
  end type partner_t

  type :: bus_t
    private
    type(c_ptr) :: handle = c_null_ptr
    character(64), allocatable :: sets(:)
    integer, allocatable :: sizes(:)
  contains
    procedure :: join, communicator, folder, scene, setting, setting_text, partner, points, output, input, scalar
    procedure :: task, next, fail, leave
  end type bus_t

contains

  pure function c_text(text) result(c)
    character(*), intent(in) :: text
    character(kind=c_char, len=:), allocatable :: c
    c = trim(text) // c_null_char
  end function c_text

  function f_text(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: n
    if (.not. c_associated(pointer)) then
      text = ''
      return
    end if
    call c_f_pointer(pointer, letters, [huge(1)])
    n = 0
    do while (letters(n + 1) /= c_null_char)
      n = n + 1
    end do
    allocate(character(n) :: text)
    text = transfer(letters(1:n), text)
  end function f_text

  !> After a failure the process ends at once: others may still write into its memory, and MPI is not finalised.
  subroutine end_if(code)
    integer(c_int), intent(in) :: code
    interface
      subroutine c_exit(code) bind(C, name='_exit')
        import :: c_int
        integer(c_int), value :: code
      end subroutine c_exit
    end interface
    if (code == 0) return
    flush (6)
    call c_exit(code)
  end subroutine end_if

  !> The name of the scene, if the launcher tells it, goes before `name`.
  subroutine join(bus, name, program)
    class(bus_t), intent(inout) :: bus
    character(*), intent(in) :: name, program
    call end_if(c_heartbus_join(bus%handle, c_text(name), c_text(program)))
    bus%sets = [character(64) ::]
    allocate(bus%sizes(0))
  end subroutine join

  !> The ranks of this participant alone.
  integer function communicator(bus)
    class(bus_t), intent(in) :: bus
    communicator = c_heartbus_communicator(bus%handle)
  end function communicator

  function folder(bus) result(text)
    class(bus_t), intent(in) :: bus
    character(:), allocatable :: text
    text = f_text(c_heartbus_folder(bus%handle))
  end function folder

  function scene(bus) result(text)
    class(bus_t), intent(in) :: bus
    character(:), allocatable :: text
    text = f_text(c_heartbus_scene(bus%handle))
  end function scene

  !> What the scene says under participants.NAME.settings, in `unit`; '1' for plain numbers.
  subroutine setting(bus, key, unit, value)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: key, unit
    real(c_double), intent(inout) :: value
    call end_if(c_heartbus_setting(bus%handle, c_text(key), c_text(unit), value))
  end subroutine setting

  function setting_text(bus, key, fallback) result(text)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: key, fallback
    character(:), allocatable :: text
    text = f_text(c_heartbus_setting_text(bus%handle, c_text(key), c_text(fallback)))
  end function setting_text

  function partner(bus, participant, point_set) result(them)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: participant, point_set
    type(partner_t) :: them
    type(heartbus_partner_points) :: got
    integer(c_int), pointer :: faces(:, :)
    call end_if(c_heartbus_partner(bus%handle, c_text(participant), c_text(point_set), got))
    call c_f_pointer(got%points, them%points, [3, got%n_points])
    them%spacing = got%spacing
    allocate(them%faces(got%n_corners, got%n_faces))
    if (got%n_faces == 0) return
    call c_f_pointer(got%faces, faces, [got%n_corners, got%n_faces])
    them%faces = faces + 1
  end function partner

  !> Points that this rank owns, (3, n) [m], and the smallest distance between neighbours [m].
  subroutine points(bus, name, coordinates, spacing)
    class(bus_t), intent(inout) :: bus
    character(*), intent(in) :: name
    real(c_double), intent(in) :: coordinates(:, :), spacing
    integer :: n
    n = size(coordinates, 2)
    call end_if(c_heartbus_points(bus%handle, c_text(name), n, reshape(coordinates, [3 * n]), spacing))
    bus%sets = [character(64) :: bus%sets, name]
    bus%sizes = [bus%sizes, n]
  end subroutine points

  subroutine view(bus, pointer, point_set, components, values)
    class(bus_t), intent(in) :: bus
    type(c_ptr), intent(in) :: pointer
    character(*), intent(in) :: point_set
    integer, intent(in) :: components
    real(c_double), pointer, intent(out) :: values(:, :)
    integer :: k, n
    if (.not. c_associated(pointer)) call end_if(c_heartbus_leave(bus%handle))
    n = 1
    do k = 1, size(bus%sizes)
      if (bus%sets(k) == point_set) n = bus%sizes(k)
    end do
    call c_f_pointer(pointer, values, [components, n])
  end subroutine view

  !> The array to be filled, (components, n); without a point set, '', n is 1.
  function output(bus, field, point_set, components, unit) result(values)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: field, point_set, unit
    integer, intent(in) :: components
    real(c_double), pointer :: values(:, :)
    call view(bus, c_heartbus_output(bus%handle, c_text(field), c_text(point_set), components, c_text(unit)), &
              point_set, components, values)
  end function output

  !> The array that is filled before the order that needs it.
  function input(bus, field, point_set, components, unit) result(values)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: field, point_set, unit
    integer, intent(in) :: components
    real(c_double), pointer :: values(:, :)
    call view(bus, c_heartbus_input(bus%handle, c_text(field), c_text(point_set), components, c_text(unit)), &
              point_set, components, values)
  end function input

  !> A number for the history.
  function scalar(bus, name, unit, combine) result(place)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: name, unit
    integer, intent(in) :: combine
    real(c_double), pointer :: place
    type(c_ptr) :: pointer
    pointer = c_heartbus_scalar(bus%handle, c_text(name), c_text(unit), combine)
    if (.not. c_associated(pointer)) call end_if(c_heartbus_leave(bus%handle))
    call c_f_pointer(pointer, place)
  end function scalar

  subroutine task(bus, name)
    class(bus_t), intent(in) :: bus
    character(*), intent(in) :: name
    call end_if(c_heartbus_task(bus%handle, c_text(name)))
  end subroutine task

  !> Waits asleep for the next order; false when there is none.
  logical function next(bus, order)
    class(bus_t), intent(in) :: bus
    type(order_t), intent(out) :: order
    type(heartbus_order) :: got
    next = c_heartbus_next(bus%handle, got) /= heartbus_end
    order%what = got%what
    order%number = got%number
    order%iteration = got%iteration
    order%time = got%time
    order%size = got%size
    order%text = f_text(got%text)
  end function next

  !> Ends the launch with this message as the cause.
  subroutine fail(bus, code, message)
    class(bus_t), intent(in) :: bus
    integer, intent(in) :: code
    character(*), intent(in) :: message
    call end_if(c_heartbus_fail(bus%handle, code, c_text(message)))
  end subroutine fail

  !> Waits until all have come to the end.
  subroutine leave(bus)
    class(bus_t), intent(inout) :: bus
    call end_if(c_heartbus_leave(bus%handle))
    bus%handle = c_null_ptr
  end subroutine leave

end module heartbus
