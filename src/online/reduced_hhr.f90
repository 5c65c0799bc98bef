! SPDX-License-Identifier: BSD-3-Clause
!> Hybrid hyper-reduction: (10) condensed on the multipliers of its domain; the other multipliers are reconstructed.
module sig_reduced_hhr
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t
  use sig_bits, only: unpack_bits
  use sig_errors, only: error_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_free_motions, only: count_free_motions
  use sig_hhr_data, only: add_lifted, complete_cluster, fill_openings, hhr_data_t
  use sig_hhr_description, only: describe_hhr
  use sig_hhr_file, only: find_hhr_mismatch, read_cluster, write_cluster
  use sig_hhr_room, only: hhr_room_t, swap_roles, take
  use sig_hhr_system, only: hhr_system_t
  use sig_kinds, only: rk
  use sig_lifted_certificate, only: lifted_certificate_t
  use sig_lcp, only: find_other_solution, lcp_solution_t, solve_lcp
  use sig_linear_algebra, only: multiply
  use sig_model_data, only: model_sizes_t
  use sig_multiplier_fit, only: multiplier_fit_t, work_of_loads
  use sig_reasons, only: reason_blind, reason_no_material, reason_singular
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_text, only: string_t
  implicit none(type, external)
  private
  public :: reduced_hhr_t

  !> [-] penetration up to this share of the snapshots' largest normal displacement counts as an error of the modes
  real(rk), parameter :: noticeable = 1.0e-2_rk

  type, extends(reduced_t) :: reduced_hhr_t
    type(hhr_data_t) :: data
    type(hhr_system_t), private :: system
    type(multiplier_fit_t), private :: fit
    type(lifted_certificate_t), private :: certificate
    !> [length] largest normal displacement in the snapshots
    real(rk), private :: largest_value = 0
  contains
    procedure :: kind => kind_of
    procedure :: complete
    procedure :: mismatch
    procedure :: prepare
    procedure :: create_room
    procedure :: solve
    procedure :: fill_multipliers
    procedure :: fill_displacement
    procedure :: displacement_of_dof
    procedure :: contact_rows
    procedure :: n_rows
    procedure :: n_modes
    procedure :: write
    procedure :: read
    procedure :: describe
    procedure :: cells
    procedure :: interior_dofs
    procedure :: training_points
    procedure :: warnings
    procedure :: displace_under
    procedure :: starts_from_two_sides
    procedure :: can_certify
    procedure :: certify
  end type reduced_hhr_t

contains

  pure function kind_of(self) result(name)
    class(reduced_hhr_t), intent(in) :: self
    character(:), allocatable :: name

    name = 'hhr'
  end function kind_of

  !> Allocates each array of the data that is not allocated, with size 0 except for lifted_terms (complete_cluster).
  pure subroutine complete(self, sizes)
    class(reduced_hhr_t), intent(inout) :: self
    type(model_sizes_t), intent(in) :: sizes

    call complete_cluster(self%data, sizes%n_dofs, sizes%n_multipliers)
  end subroutine complete

  !> Returns the name of an array whose shape or values do not fit the model; empty when all fit (find_hhr_mismatch).
  pure function mismatch(self, sizes) result(name)
    class(reduced_hhr_t), intent(in) :: self
    type(model_sizes_t), intent(in) :: sizes
    character(:), allocatable :: name

    name = find_hhr_mismatch(self%data, sizes)
  end function mismatch

  !> Prepares the fit of the forces, the certificate and, if the stiffness does not depend on the parameters, the system (10).
  !> Errors: message is allocated if the reduced stiffness is numerically singular, or if the equations do not determine the forces
  !> of the anchors (hhr_system_t%create). A stiffness that depends on the parameters is checked in each query.
  subroutine prepare(self, message)
    class(reduced_hhr_t), intent(inout) :: self
    character(:), allocatable, intent(out) :: message

    call self%fit%prepare(self%data)
    call self%certificate%prepare(self%data)
    self%largest_value = maxval([0.0_rk, abs(self%data%contact_displacement_snapshots)])
    if (.not. self%data%varying%is_there()) call self%system%create(self%data, message)
  end subroutine prepare

  !> Makes the work arrays for one thread.
  subroutine create_room(self, room)
    class(reduced_hhr_t), intent(in) :: self
    class(room_t), allocatable, intent(out) :: room
    type(hhr_room_t), allocatable :: own

    allocate (own)
    call own%create(self%data)
    call move_alloc(own, room)
  end subroutine create_room

  !> Solves the complementarity problem of the domain. A solution without contact forces does not count as an answer if some contact
  !> must touch (reason_blind, from is_blind). Without a solution the reason is that of solve_lcp or, if the stiffness depends on
  !> the parameters, reason_no_material or reason_singular. Arguments: solve_at in sig_reduced.
  subroutine solve(self, theta, near, room, answer, judge)
    class(reduced_hhr_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge

    select type (room)
    type is (hhr_room_t)
      if (self%data%varying%is_there()) then
        call solve_varying(self, theta, near, room, answer, judge)
      else
        call multiply(1.0_rk, self%system%response, theta, 0.0_rk, room%response)
        call solve_from_sets(self, self%system, theta, near, room, answer, judge)
      end if
      if (answer%reason < 0) return
      call count_motions(self, room, answer)
      if (any(answer%multipliers_rid > 0)) return
      if (is_blind(self, theta, answer%coordinates, room%opening)) answer%reason = reason_blind
    end select
  end subroutine solve

  !> Makes the equations (10) of the point, where the stiffness depends on the parameters, and solves them (solve_from_sets).
  subroutine solve_varying(self, theta, near, room, answer, judge)
    class(reduced_hhr_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    type(hhr_room_t), target, intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge

    answer%reason = reason_no_material
    if (.not. self%data%varying%has_material(theta)) return
    call room%system%assemble(self%data, theta, room%response, room%is_singular)
    answer%reason = reason_singular
    if (.not. room%is_singular) call solve_from_sets(self, room%system, theta, near, room, answer, judge)
  end subroutine solve_varying

  !> Solves from the active set of the nearest training point; without this set from the rows with a negative q, which penetrate
  !> without contact forces. If there is an answer, and the set of near%opposite is known and differs, it looks for a second
  !> solution from that set.
  subroutine solve_from_sets(self, system, theta, near, room, answer, judge)
    class(reduced_hhr_t), intent(in) :: self
    !> system whose response is in the room
    type(hhr_system_t), intent(in) :: system
    real(rk), contiguous, intent(in) :: theta(:)
    type(neighbors_t), intent(in) :: near
    type(hhr_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge
    integer :: n_iterations

    associate (n => self%data%n_rows, sets => self%data%start_sets)
      if (near%nearest >= 1 .and. near%nearest <= size(sets, 2)) then
        call unpack_bits(sets(:, near%nearest), room%start)
        call swap_roles(system%anchors, room%start)
      else
        room%start = room%response(:n) < 0
      end if
      call solve_lcp(system%condensed, room%response(:n), room%start, room%solution, room%workspace)
      call take(system, room, room%solution, answer)
      if (answer%reason < 0 .or. near%opposite < 1 .or. max(near%nearest, near%opposite) > size(sets, 2)) return
      if (all(sets(:, near%opposite) == sets(:, near%nearest))) return
      n_iterations = answer%n_iterations
      call unpack_bits(sets(:, near%opposite), room%start)
      call swap_roles(system%anchors, room%start)
      call look_for_other(self, system, theta, room, answer, judge)
      answer%n_iterations = n_iterations + room%other_solution%n_iterations
    end associate
  end subroutine solve_from_sets

  !> Looks for a second solution from another active set. If there is one, n_solutions becomes 2, and the second solution becomes
  !> the answer if the judge finds a smaller energy of all its forces; without a judge the first solution stays.
  !>
  !> (10) may have several solutions, because its matrix is neither symmetric nor a P-matrix. The full-order forces lambda are the
  !> minimum of E(lambda) = 1/2 lambda' W lambda + q' lambda over lambda >= 0, with W and q of all contacts. For other forces
  !> lambda_r >= 0, E(lambda_r) - E(lambda) = 1/2 (lambda_r - lambda)' W (lambda_r - lambda) + lambda_r' w(lambda) >= 0.
  subroutine look_for_other(self, system, theta, room, answer, judge)
    class(reduced_hhr_t), intent(in) :: self
    type(hhr_system_t), intent(in) :: system
    real(rk), contiguous, intent(in) :: theta(:)
    !> in: response of the point; `solution` is the first solution, and `start` is the other active set
    type(hhr_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer
    class(reduced_t), intent(in), optional :: judge
    real(rk) :: energy
    logical :: is_found

    call find_other_solution(system%condensed, room%response(:self%data%n_rows), room%start, room%solution, &
      room%other_solution, room%workspace, is_found)
    if (.not. is_found) return
    if (present(judge)) then
      energy = force_energy(self, system, theta, judge, room%solution, room)
      if (force_energy(self, system, theta, judge, room%other_solution, room) < energy) &
        call take(system, room, room%other_solution, answer)
    end if
    answer%n_solutions = 2
  end subroutine look_for_other

  !> Returns the energy E [force*length] of a solution by the judge, with the reconstructed forces of all contacts.
  real(rk) function force_energy(self, system, theta, judge, solution, room) result(energy)
    class(reduced_hhr_t), intent(in) :: self
    type(hhr_system_t), intent(in) :: system
    real(rk), contiguous, intent(in) :: theta(:)
    class(reduced_t), intent(in) :: judge
    type(lcp_solution_t), intent(in) :: solution
    type(hhr_room_t), intent(inout) :: room

    call system%forces_of(solution%lambda, room%response, room%forces, room%held_forces)
    call system%coordinates(room%response, room%held_forces, room%coordinates)
    call self%fit%evaluate(self%data, theta, room%coordinates, room%forces, room%fit, room%multipliers)
    energy = judge%energy(theta, room%multipliers)
  end function force_energy

  !> Sets n_free_motions of an answer: by the forces of the domain or, if these do not hold all motions, by the forces of all
  !> contacts, which are then reconstructed in the room. Requires: an answer of the part.
  subroutine count_motions(self, room, answer)
    class(reduced_hhr_t), intent(in) :: self
    type(hhr_room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    associate (closing => self%data%motion_closing)
      if (size(closing, 2) == 0) return
      answer%n_free_motions = count_free_motions(closing(self%data%contact_rows, :), answer%multipliers_rid)
      if (answer%n_free_motions == 0) return
      call self%fit%evaluate(self%data, answer%theta, answer%coordinates, answer%multipliers_rid, room%fit, room%multipliers)
      answer%n_free_motions = count_free_motions(closing, room%multipliers)
    end associate
  end subroutine count_motions

  !> Whether some contact must carry a force although no contact of the domain does: the loads do work on a rigid motion that only
  !> contact holds; or, by the reduced displacement, some contact penetrates by more than 1 % of largest_value. The second check is
  !> left out if the model lacks the data for openings. Requires: an answer without contact forces in the domain.
  logical function is_blind(self, theta, coordinates, opening)
    class(reduced_hhr_t), intent(in) :: self
    !> shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma, shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    logical :: is_known

    is_blind = any(abs(work_of_loads(self%data, theta)) > 0)
    if (is_blind) return
    call fill_openings(self%data, theta, coordinates, opening, is_known)
    if (is_known) is_blind = any(opening < -noticeable * self%largest_value)
  end function is_blind

  !> Computes the forces of all contacts: the answer's forces in the domain, the fit elsewhere (evaluate of sig_multiplier_fit). If
  !> only contact holds a body, all forces are changed so that they balance the loads, if this is possible.
  subroutine fill_multipliers(self, answer, room, multipliers)
    class(reduced_hhr_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    class(room_t), intent(inout) :: room
    real(rk), intent(out) :: multipliers(:)

    select type (room)
    type is (hhr_room_t)
      call self%fit%evaluate(self%data, answer%theta, answer%coordinates, answer%multipliers_rid, room%fit, multipliers)
    end select
  end subroutine fill_multipliers

  !> Computes the displacement [length] of all dofs, u = lifting theta' + basis gamma, with the lifted terms theta'.
  subroutine fill_displacement(self, answer, displacement)
    class(reduced_hhr_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    real(rk), contiguous, intent(inout) :: displacement(:)

    displacement = 0
    call add_lifted(self%data, 1.0_rk, self%data%lifting, answer%theta, displacement)
    call multiply(1.0_rk, self%data%basis, answer%coordinates, 1.0_rk, displacement)
  end subroutine fill_displacement

  !> Returns the displacement [length] of one dof, 1-based.
  pure real(rk) function displacement_of_dof(self, answer, dof) result(displacement)
    class(reduced_hhr_t), intent(in) :: self
    type(answer_t), intent(in) :: answer
    integer, intent(in) :: dof

    displacement = dot_product(self%data%lifting(dof, :), answer%theta(self%data%lifted_terms)) + &
      dot_product(self%data%basis(dof, :), answer%coordinates)
  end function displacement_of_dof

  !> Returns the contact rows of the domain, 1-based among those of the model.
  pure function contact_rows(self) result(numbers)
    class(reduced_hhr_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    numbers = self%data%contact_rows
  end function contact_rows

  !> Returns the number of contact rows of the domain.
  pure integer function n_rows(self)
    class(reduced_hhr_t), intent(in) :: self

    n_rows = self%data%n_rows
  end function n_rows

  !> Returns the number of columns of the basis: POD modes and hats.
  pure integer function n_modes(self)
    class(reduced_hhr_t), intent(in) :: self

    n_modes = self%data%n_modes
  end function n_modes

  !> Writes the part to a group of a model file (write_cluster). Arguments: write_to in sig_model_data.
  subroutine write(self, file, group, length, force)
    class(reduced_hhr_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    character(*), intent(in) :: group
    character(*), intent(in) :: length
    character(*), intent(in) :: force

    call write_cluster(file, group, self%data, length, force)
  end subroutine write

  !> Reads the part from a group (read_cluster). Errors: a dataset or attribute is missing, or has another type or rank.
  subroutine read(self, file, group, error)
    class(reduced_hhr_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    character(*), intent(in) :: group
    type(error_t), allocatable, intent(inout) :: error

    call read_cluster(file, group, self%data, error)
  end subroutine read

  !> Returns lines about the part, each with its line end (describe_hhr).
  pure function describe(self) result(text)
    class(reduced_hhr_t), intent(in) :: self
    character(:), allocatable :: text

    text = describe_hhr(self%data)
  end function describe

  !> Returns the numbers of the cells of the reduced integration domain, natural, 1-based.
  pure function cells(self) result(numbers)
    class(reduced_hhr_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    numbers = self%data%cells
  end function cells

  !> Returns the numbers of the dofs of the domain that have an equation in (10), natural, 1-based.
  pure function interior_dofs(self) result(numbers)
    class(reduced_hhr_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    numbers = self%data%interior_dofs
  end function interior_dofs

  !> Returns the training points whose snapshots the cluster has, 1-based.
  pure function training_points(self) result(numbers)
    class(reduced_hhr_t), intent(in) :: self
    integer, allocatable :: numbers(:)

    numbers = self%data%training_points
  end function training_points

  pure function warnings(self)
    class(reduced_hhr_t), intent(in) :: self
    type(string_t), allocatable :: warnings(:)

    warnings = self%data%warnings
  end function warnings

  !> Returns true: solve starts from two active sets, because (10) may have several solutions.
  pure logical function starts_from_two_sides(self)
    class(reduced_hhr_t), intent(in) :: self

    starts_from_two_sides = .true.
  end function starts_from_two_sides

  !> Sets gamma (coordinates), the forces of the domain and is_active of the answer to those under the forces of all contacts that
  !> another part found at the same point. The anchors of this part count as closed, because forces do not determine the place of
  !> their bodies. gamma is NaN if solve found no equations (reason_singular). Requires: solve at this point with this room.
  subroutine displace_under(self, room, answer)
    class(reduced_hhr_t), intent(in) :: self
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    select type (room)
    type is (hhr_room_t)
      answer%multipliers_rid = answer%multipliers(self%data%contact_rows)
      answer%is_active = answer%multipliers_rid > 0
      if (room%is_singular) then
        answer%coordinates = ieee_value(1.0_rk, ieee_quiet_nan)
      else if (self%data%varying%is_there()) then
        call room%system%coordinates(room%response, answer%multipliers_rid, answer%coordinates)
      else
        call self%system%coordinates(room%response, answer%multipliers_rid, answer%coordinates)
      end if
    end select
  end subroutine displace_under

  !> Whether the part has a certificate of its own. Training makes one only in models that have a max_error but no fallback.
  pure logical function can_certify(self)
    class(reduced_hhr_t), intent(in) :: self

    can_certify = self%certificate%is_there
  end function can_certify

  !> Bounds the error of the part's own answer, if its forces are a combination that has a bound (certify of
  !> sig_lifted_certificate). Forces that another part found get no bound. Arguments: no_certificate in sig_reduced. Requires:
  !> can_certify, and that the last call of fill_multipliers with this room was for this answer.
  subroutine certify(self, multipliers, is_own, room, answer)
    class(reduced_hhr_t), intent(in) :: self
    real(rk), contiguous, intent(in) :: multipliers(:)
    logical, intent(in) :: is_own
    class(room_t), intent(inout) :: room
    type(answer_t), intent(inout) :: answer

    if (.not. is_own) return
    select type (room)
    type is (hhr_room_t)
      call self%certificate%certify(self%data, room%fit%coefficients, multipliers, answer)
    end select
  end subroutine certify
end module sig_reduced_hhr
