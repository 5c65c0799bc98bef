! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The contact problem with simple bounds: in unknowns x with u = T x, B_k u <= D_k becomes x_j <= bound for one unknown j per row.
!>
!> The free dofs of a row are its own, or shared with other rows (a node of the second side that faces several nodes). Let |B_k| be
!> the norm of its coefficients on its own dofs, q_k = these coefficients / |B_k|, and s_k = those on shared dofs / |B_k|. The
!> reflection I - 2 v v' with v along q_k - e_j swaps q_k and e_j on the own dofs, and x_j = q_k' u + s_k' u, so that u = R (x - e_j
!> s_k' x). Own dofs belong to one row each, hence all rows together are one change of unknowns T: K becomes T' K T and stays
!> symmetric and positive definite, and lambda_k is the residual of unknown j over -|B_k|. Rows that share nothing make T = R,
!> orthogonal.
!>
!> The owner of a row may be part of other rows, which have owners of their own: a corner of quadratic faces, and the mid-side nodes
!> beside it. These rows change their unknowns first, as if the corner were shared; then the corner's own row is alone with it. With
!> T_1 of the former and T_2 of the latter T = T_1 T_2, because T_2 moves only what T_1 takes as given.
!>
!> A contact with friction or a tie has tangential rows beside its normal row, on the same dofs. They change their unknowns one
!> after the other, the normal row first: each row is written in the unknowns that the rows before have left, where those that they
!> took count as shared. All rows of a contact change their unknowns, or none.
module sig_bound_form
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_system, only: contact_system_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: create_pattern_of => create_matrix, precondition_failed
  use sig_rounding, only: dependent
  use petsc
  implicit none(type, external)
  private
  public :: bound_form_t, renew_matrix

  !> The transformation T for the contact rows of one system. Call create, then the other procedures. Some of them take only some
  !> rows into their change of unknowns; the unknowns at the others are displacements.
  type :: bound_form_t
    !> [-] |B_k| on the row's own free dofs, shape (n_rows)
    real(rk), allocatable :: norms(:)
    !> level of each contact, whose number is that of its normal row: rows of one level change their unknowns together, 1 = first;
    !> shape (n_contacts)
    integer, allocatable :: levels(:)
    !> rows sorted by the level of their contact, lowest first, those of a contact together: T' and T^-1 treat the rows in this
    !> order, T in the opposite one; shape (n_rows)
    integer, allocatable :: order(:)
    !> natural dof whose place the bounded unknown of row k takes, shape (n_rows)
    integer, allocatable :: bounded_dofs(:)
    !> [-] v of all rows, of unit length or zero; entry i belongs to rows%dofs(i)
    real(rk), allocatable :: reflectors(:)
    !> [-] s of all rows; entry i belongs to rows%dofs(i)
    real(rk), allocatable :: shares(:)
  contains
    procedure :: create
    procedure :: set_reflectors
    procedure :: create_transformation
    procedure :: create_matrix
    procedure :: to_displacement
    procedure :: to_unknowns
    procedure :: to_forces_on_unknowns
    procedure :: bounds
    procedure :: multipliers
  end type bound_form_t

contains

  !> Prepares T for a system. T gives the displacement u = T x from unknowns x in which each contact row is an upper bound of one
  !> unknown. Requires: each normal row has a coefficient other than 0 on a free dof of a node that no other one of its level or of
  !> a higher one meets; otherwise ierr is set. A tangential row for which such nodes have too few free dofs gets the norm 0, and T
  !> is of no use. Local.
  subroutine create(self, system, ierr)
    class(bound_form_t), intent(out) :: self
    type(contact_system_t), intent(in) :: system
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    call self%set_reflectors(system%rows, system%laws, system%boundary%is_prescribed)
    SIG_CHECK(all(self%norms(:system%laws%n_contacts) > 0), PETSC_ERR_ARG_WRONG, 'each contact row has a free dof of its own')
  end subroutine create

  !> Makes T or its inverse as a matrix, with a factor for each level: T = T_1 T_2 ..., T^-1 = ... T_2^-1 T_1^-1; the identity
  !> without rows. Its pattern is that of all rows, whatever rows change the unknowns. The caller destroys it. Collective.
  subroutine create_transformation(self, system, is_changed, is_inverse, matrix, ierr)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> rows that change their unknowns, all or none of a contact, shape (n_rows)
    logical, intent(in) :: is_changed(:)
    logical, intent(in) :: is_inverse
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr
    Mat :: next, product
    integer :: i_level

    PetscCall(assemble(self, system, 1, is_changed, is_inverse, matrix, ierr))
    do i_level = 2, maxval([1, self%levels])
      PetscCall(assemble(self, system, i_level, is_changed, is_inverse, next, ierr))
      if (is_inverse) then
        PetscCall(MatMatMult(next, matrix, MAT_INITIAL_MATRIX, 2.0_rk, product, ierr))
      else
        PetscCall(MatMatMult(matrix, next, MAT_INITIAL_MATRIX, 2.0_rk, product, ierr))
      end if
      PetscCall(MatProductClear(product, ierr))
      PetscCall(MatDestroy(next, ierr))
      PetscCall(MatDestroy(matrix, ierr))
      matrix = product
    end do
  end subroutine create_transformation

  !> Makes T' K T with all rows in T, on all dofs. The caller destroys it. Collective.
  subroutine create_matrix(self, system, matrix, ierr, is_renewed)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr
    !> whether renew_matrix will be called; default: no
    logical, intent(in), optional :: is_renewed
    logical :: is_kept
    Mat :: transformation

    PetscCall(self%create_transformation(system, spread(.true., 1, system%rows%n_rows), .false., transformation, ierr))
    PetscCall(MatPtAP(system%stiffness, transformation, MAT_INITIAL_MATRIX, 2.0_rk, matrix, ierr))
    ! what a second product uses, T too, is larger than K
    is_kept = .false.
    if (present(is_renewed)) is_kept = is_renewed
    if (.not. is_kept) then
      PetscCall(MatProductClear(matrix, ierr))
    end if
    PetscCall(MatDestroy(transformation, ierr))
    PetscCall(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine create_matrix

  !> Computes T' K T again after new values in K, whose pattern stays. Collective.
  subroutine renew_matrix(matrix, ierr)
    !> of create_matrix with is_renewed
    Mat, intent(inout) :: matrix
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatProductNumeric(matrix, ierr))
    PetscCall(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE, ierr))
  end subroutine renew_matrix

  !> Sets levels, order, norms, bounded dofs, v and s of all rows. A row without coefficients on free dofs of its own gets the norm
  !> 0 and no bounded dof, as does a tangential row that depends on the rows of its contact before it.
  pure subroutine set_reflectors(self, rows, laws, is_prescribed)
    class(bound_form_t), intent(inout) :: self
    !> of all forces
    type(contact_rows_t), intent(in) :: rows
    type(contact_laws_t), intent(in) :: laws
    !> natural dofs, shape (n_dofs)
    logical, intent(in) :: is_prescribed(:)
    integer, allocatable :: contacts(:)
    logical, allocatable :: is_own(:)
    integer :: i, i_level, k

    allocate (self%norms(rows%n_rows), source=0.0_rk)
    allocate (self%bounded_dofs(rows%n_rows), source=0)
    allocate (self%reflectors(size(rows%dofs)), self%shares(size(rows%dofs)), source=0.0_rk)
    call rank_rows(rows%select([(k, k=1, laws%n_contacts)]), size(is_prescribed) / rows%n_dim, self%levels, contacts)
    self%order = [(laws%rows_of(contacts(i)), i=1, size(contacts))]
    i_level = 0
    do i = 1, size(contacts)
      k = contacts(i)
      if (self%levels(k) > i_level) is_own = is_own_dof(self, rows, laws%n_contacts, size(is_prescribed), self%levels(k))
      i_level = self%levels(k)
      associate (dofs => rows%dofs_of(k))
        call reflect_contact(self, rows, laws%rows_of(k), is_prescribed(dofs), is_own(dofs) .and. .not. is_prescribed(dofs))
      end associate
    end do
  end subroutine set_reflectors

  !> Does the work of set_reflectors for one contact.
  pure subroutine reflect_contact(self, all_rows, rows, is_prescribed, is_own)
    class(bound_form_t), intent(inout) :: self
    type(contact_rows_t), intent(in) :: all_rows
    !> those of the contact
    integer, intent(in) :: rows(:)
    !> of their dofs, and which are free dofs of its own; shape (dofs of a row)
    logical, intent(in) :: is_prescribed(:)
    logical, intent(in) :: is_own(:)
    real(rk) :: coefficients(size(is_own)), direction(size(is_own)), length
    logical :: is_left(size(is_own))
    integer :: i, j, place

    is_left = is_own
    associate (offsets => all_rows%offsets, dofs => all_rows%dofs_of(rows(1)))
      do i = 1, size(rows)
        coefficients = merge(0.0_rk, all_rows%coefficients_of(rows(i)), is_prescribed)
        length = norm2(coefficients)
        do j = 1, i - 1
          if (.not. self%norms(rows(j)) > 0) cycle
          call to_covector(self, offsets(rows(j)), findloc(dofs, self%bounded_dofs(rows(j)), dim=1), coefficients)
        end do
        direction = merge(coefficients, 0.0_rk, is_left)
        if (.not. norm2(direction) > merge(0.0_rk, dependent * length, i == 1)) cycle
        self%norms(rows(i)) = norm2(direction)
        associate (first => offsets(rows(i)) + 1, last => offsets(rows(i)) + size(dofs))
          self%shares(first:last) = merge(0.0_rk, coefficients, is_left) / self%norms(rows(i))
          direction = direction / self%norms(rows(i))
          place = maxloc(abs(direction), dim=1)
          self%bounded_dofs(rows(i)) = dofs(place)
          is_left(place) = .false.
          direction(place) = direction(place) - 1
          length = norm2(direction)
          if (length > 0) self%reflectors(first:last) = direction / length
        end associate
      end do
    end associate
  end subroutine reflect_contact

  !> Writes a row of a contact in the unknowns that an earlier one of its rows leaves: T' of this row times the coefficients.
  pure subroutine to_covector(self, offset, place, coefficients)
    class(bound_form_t), intent(in) :: self
    !> of the earlier row
    integer, intent(in) :: offset
    !> of its bounded dof among its dofs
    integer, intent(in) :: place
    real(rk), intent(inout) :: coefficients(:)
    integer :: last

    last = offset + size(coefficients)
    associate (v => self%reflectors(offset + 1:last), s => self%shares(offset + 1:last))
      coefficients = coefficients - 2 * v * dot_product(v, coefficients)
      coefficients = coefficients - s * coefficients(place)
    end associate
  end subroutine to_covector

  !> Finds the levels of the normal rows. Level 1: rows whose owner no other row meets. Level 2: rows whose owner no other row meets
  !> except those of level 1; and so on.
  !>
  !> If rows remain for which this gives no level, they all get one last level. create refuses such a row, unless it has
  !> coefficients on free dofs of another node that no other row of this level meets.
  pure subroutine rank_rows(rows, n_nodes, levels, order)
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_nodes
    !> as in bound_form_t
    integer, allocatable, intent(out) :: levels(:), order(:)
    integer :: i_level, k, n(n_nodes), owners(rows%n_rows)
    logical :: is_next(rows%n_rows)

    owners = rows%owners()
    n = rows%rows_per_node(n_nodes)
    allocate (levels(rows%n_rows), source=0)
    allocate (order(0))
    i_level = 0
    do while (any(levels == 0))
      i_level = i_level + 1
      is_next = levels == 0 .and. n(owners) == 1
      if (.not. any(is_next)) is_next = levels == 0
      levels = merge(i_level, levels, is_next)
      order = [order, pack([(k, k=1, rows%n_rows)], is_next)]
      do k = 1, rows%n_rows
        if (is_next(k)) n(rows%nodes_of(k)) = n(rows%nodes_of(k)) - 1
      end do
    end do
  end subroutine rank_rows

  !> Returns which dofs, prescribed ones too, belong to nodes that exactly one row meets, where rows of lower levels than i_level do
  !> not count; shape (n_dofs).
  pure function is_own_dof(self, rows, n_contacts, n_dofs, i_level) result(is_own)
    class(bound_form_t), intent(in) :: self
    type(contact_rows_t), intent(in) :: rows
    integer, intent(in) :: n_contacts
    integer, intent(in) :: n_dofs
    !> level, 1-based
    integer, intent(in) :: i_level
    logical, allocatable :: is_own(:)
    integer :: k, n(n_dofs / rows%n_dim)

    n = 0
    do k = 1, n_contacts
      if (self%levels(k) < i_level) cycle
      associate (nodes => rows%nodes_of(k))
        n(nodes) = n(nodes) + 1
      end associate
    end do
    is_own = reshape(spread(n == 1, 1, rows%n_dim), [n_dofs])
  end function is_own_dof

  !> Assembles one factor of the transformation T, or the inverse of this factor: the identity plus one block per contact of a
  !> level. The rows of a block are the contact's own dofs (is_own_dof), its columns all dofs of its rows. Collective.
  subroutine assemble(self, system, i_level, is_changed, is_inverse, matrix, ierr)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    integer, intent(in) :: i_level
    !> rows whose block is not zero, shape (n_rows)
    logical, intent(in) :: is_changed(:)
    logical, intent(in) :: is_inverse
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr
    integer :: i, k
    integer, allocatable :: dofs_0(:), own(:)
    real(rk), allocatable :: block(:, :)
    logical, allocatable :: is_own(:)

    is_own = is_own_dof(self, system%rows, system%laws%n_contacts, system%map%n_dofs, i_level)
    PetscCall(create_pattern(self, system, i_level, is_own, matrix, ierr))
    associate (map => system%map, rows => system%rows)
      do i = map%first_dof_0, map%first_dof_0 + map%n_local_dofs - 1
        PetscCall(MatSetValue(matrix, i, i, 1.0_rk, ADD_VALUES, ierr))
      end do
      do k = 1, system%laws%n_contacts
        if (self%levels(k) /= i_level) cycle
        dofs_0 = map%distributed_0(rows%dofs_of(k))
        own = pack([(i, i=1, size(dofs_0))], is_own(rows%dofs_of(k)) .and. dofs_0 >= map%first_dof_0 .and. &
          dofs_0 < map%first_dof_0 + map%n_local_dofs)
        if (size(own) == 0) cycle
        block = transpose(block_of_contact(self, system, k, own, is_inverse))
        if (.not. is_changed(k)) block = 0
        PetscCall(MatSetValues(matrix, size(own), dofs_0(own), size(dofs_0), dofs_0, block, ADD_VALUES, ierr))
      end do
    end associate
    PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY, ierr))
    PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY, ierr))
  end subroutine assemble

  !> Returns the block of a contact in T, or in its inverse, without the identity; shape (size(own), dofs of a row).
  pure function block_of_contact(self, system, k, own, is_inverse) result(block)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    integer, intent(in) :: k
    !> dofs of the contact that belong to the block, 1-based in its rows
    integer, intent(in) :: own(:)
    logical, intent(in) :: is_inverse
    real(rk), allocatable :: block(:, :)
    real(rk), allocatable :: columns(:, :)
    integer :: i, place

    associate (rows => system%laws%rows_of(k), dofs => system%rows%dofs_of(k))
      allocate (columns(size(dofs), size(dofs)), source=0.0_rk)
      do i = 1, size(dofs)
        columns(i, i) = 1
      end do
      do i = 1, size(rows)
        associate (row => rows(merge(i, size(rows) + 1 - i, is_inverse)))
          place = findloc(dofs, self%bounded_dofs(row), dim=1)
          associate (first => system%rows%offsets(row) + 1, last => system%rows%offsets(row + 1))
            associate (v => self%reflectors(first:last), s => self%shares(first:last))
              if (is_inverse) columns = columns - 2 * spread(v, 2, size(v)) * spread(matmul(v, columns), 1, size(v))
              columns(place, :) = columns(place, :) + merge(1, -1, is_inverse) * matmul(s, columns)
              if (.not. is_inverse) columns = columns - 2 * spread(v, 2, size(v)) * spread(matmul(v, columns), 1, size(v))
            end associate
          end associate
        end associate
      end do
      do i = 1, size(dofs)
        columns(i, i) = columns(i, i) - 1
      end do
    end associate
    block = columns(own, :)
  end function block_of_contact

  !> Creates an empty matrix with memory for the diagonal block of each node and, at a row's own nodes (is_own), for blocks with all
  !> nodes of this row. Counts the contacts of this level only. Collective.
  subroutine create_pattern(self, system, i_level, is_own, matrix, ierr)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> level, 1-based
    integer, intent(in) :: i_level
    !> of is_own_dof for this level, shape (n_dofs)
    logical, intent(in) :: is_own(:)
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: diagonal(:), off_diagonal(:)
    integer :: k

    associate (map => system%map, rows => system%rows)
      allocate (diagonal(map%n_local_dofs / map%n_dim), source=1)
      allocate (off_diagonal(size(diagonal)), source=0)
      do k = 1, system%laws%n_contacts
        if (self%levels(k) /= i_level) cycle
        associate (dofs => rows%dofs(rows%offsets(k) + 1:rows%offsets(k + 1):map%n_dim))
          call map%count_blocks(dofs, is_own(dofs), diagonal, off_diagonal)
        end associate
      end do
      PetscCall(create_pattern_of(system%comm, map%n_local_dofs, map%n_dim, diagonal, off_diagonal, matrix, ierr))
    end associate
  end subroutine create_pattern

  !> Computes the displacement u = T x from the unknowns x of the bound form, in place. Local.
  pure subroutine to_displacement(self, system, values, is_changed)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [length] in: x; out: u; natural, shape (n_dofs)
    real(rk), intent(inout) :: values(:)
    !> rows that change their unknowns, shape (n_rows); default: all
    logical, intent(in), optional :: is_changed(:)
    integer :: i, k

    do i = system%rows%n_rows, 1, -1
      k = self%order(i)
      if (is_left(k, is_changed)) cycle
      associate (first => system%rows%offsets(k) + 1, last => system%rows%offsets(k + 1), j => self%bounded_dofs(k))
        values(j) = values(j) - dot_product(self%shares(first:last), values(system%rows%dofs(first:last)))
        call reflect(self%reflectors(first:last), system%rows%dofs(first:last), values)
      end associate
    end do
  end subroutine to_displacement

  !> Computes the unknowns x = T^-1 u of the bound form from the displacement u, in place. Local.
  pure subroutine to_unknowns(self, system, values, is_changed)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [length] in: u; out: x; natural, shape (n_dofs)
    real(rk), intent(inout) :: values(:)
    !> rows that change their unknowns, shape (n_rows); default: all
    logical, intent(in), optional :: is_changed(:)
    integer :: i, k

    do i = 1, system%rows%n_rows
      k = self%order(i)
      if (is_left(k, is_changed)) cycle
      associate (first => system%rows%offsets(k) + 1, last => system%rows%offsets(k + 1), j => self%bounded_dofs(k))
        call reflect(self%reflectors(first:last), system%rows%dofs(first:last), values)
        values(j) = values(j) + dot_product(self%shares(first:last), values(system%rows%dofs(first:last)))
      end associate
    end do
  end subroutine to_unknowns

  !> Computes T' f in place: from forces on the dofs to forces on the unknowns that do the same work. Local.
  pure subroutine to_forces_on_unknowns(self, system, values, is_changed)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [force] in: f; out: T' f; natural, shape (n_dofs)
    real(rk), intent(inout) :: values(:)
    !> rows that change their unknowns, shape (n_rows); default: all
    logical, intent(in), optional :: is_changed(:)
    integer :: i, k

    do i = 1, system%rows%n_rows
      k = self%order(i)
      if (is_left(k, is_changed)) cycle
      associate (first => system%rows%offsets(k) + 1, last => system%rows%offsets(k + 1), j => self%bounded_dofs(k))
        associate (dofs => system%rows%dofs(first:last))
          call reflect(self%reflectors(first:last), dofs, values)
          values(dofs) = values(dofs) - self%shares(first:last) * values(j)
        end associate
      end associate
    end do
  end subroutine to_forces_on_unknowns

  !> Whether row k leaves its unknowns as they are.
  pure logical function is_left(k, is_changed)
    integer, intent(in) :: k
    logical, intent(in), optional :: is_changed(:)

    is_left = .false.
    if (present(is_changed)) is_left = .not. is_changed(k)
  end function is_left

  !> Multiplies the values of some dofs by I - 2 v v'. The values of all other dofs stay.
  pure subroutine reflect(v, dofs, values)
    !> [-] on these dofs, of unit length or zero
    real(rk), intent(in) :: v(:)
    !> natural
    integer, intent(in) :: dofs(:)
    !> natural, shape (n_dofs)
    real(rk), intent(inout) :: values(:)

    values(dofs) = values(dofs) - 2 * v * dot_product(v, values(dofs))
  end subroutine reflect

  !> Returns the upper bounds of the unknowns bounded_dofs, (D - B u_D) / |B_k| with the prescribed displacements u_D and |B_k| of
  !> `norms`. Local.
  pure function bounds(self, system, theta)
    class(bound_form_t), intent(in) :: self
    type(contact_system_t), intent(in) :: system
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_rows)
    real(rk) :: bounds(system%rows%n_rows)

    bounds = (system%gap(theta) - system%rows%apply(system%prescribed_displacement(theta))) / self%norms
  end function bounds

  !> Returns the multipliers lambda_k = -residual_j / |B_k|, j = bounded_dofs(k), positive where the contact presses. Local.
  pure function multipliers(self, residual)
    class(bound_form_t), intent(in) :: self
    !> [force] T' (K T x - F), natural, shape (n_dofs)
    real(rk), intent(in) :: residual(:)
    !> [force] shape (n_rows)
    real(rk) :: multipliers(size(self%norms))

    multipliers = -residual(self%bounded_dofs) / self%norms
  end function multipliers
end module sig_bound_form
