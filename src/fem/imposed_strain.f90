! SPDX-License-Identifier: BSD-3-Clause
!> Imposed strains, which the bodies would have without stress: eps*(x, mu) = sum over t of theta_t(mu) eps_t(x).
!>
!> Stresses come from eps(u) - eps*. The imposed strains are given at integration points and not at nodes. So their forces are
!> integrals of exactly these strains for elements of any order, and strains may jump from one cell to the next.
module sig_imposed_strain
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: n_stresses
  use sig_element_matrices, only: physical_gradients
  use sig_kinds, only: rk
  use sig_mechanical_models, only: circumference
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_point_values, only: count_points
  use sig_term_set, only: term_set_t
  implicit none(type, external)
  private
  public :: imposed_strains_t, strain_part_t, strain_field_t, cell_strains

  !> One part of the imposed strains, in cells of one material: theta of the term * value at the integration point * direction.
  type :: strain_part_t
    !> index into imposed_strains_t%terms
    integer :: term = 1
    !> number of the material in the deck, 1-based
    integer :: material = 0
    !> 1-based
    integer, allocatable :: cells(:)
    !> [-] strain components for theta and value 1, shears as angles
    real(rk) :: direction(n_stresses) = 0
    !> values at the integration points of the cells, one cell after another; theta * value is [-]
    real(rk), allocatable :: values(:)
    !> where the value stands in the deck
    integer :: line = 0
    integer :: column = 0
  contains
    procedure :: restrict
  end type strain_part_t

  !> The imposed strains at one parameter point. The arrays are not allocated if there are no imposed strains.
  type :: strain_field_t
    private
    !> integration points of cell c: offsets(c) + 1 to offsets(c + 1); none if nothing is imposed on the cell
    integer, allocatable :: offsets(:)
    !> [-] shears as angles, shape (n_stresses, n_points)
    real(rk), allocatable :: strains(:, :)
  contains
    procedure :: at_point
  end type strain_field_t

  !> All imposed strains of a problem, the sum of the parts.
  type :: imposed_strains_t
    !> theta_t; the forces of the strains have other terms, with the moduli as factors where these depend on the parameters
    type(term_set_t) :: terms
    type(strain_part_t), allocatable :: parts(:)
  contains
    procedure :: are_there
    procedure :: add_part
    procedure :: evaluate
  end type imposed_strains_t

contains

  !> Whether there are imposed strains, that is, any part.
  pure logical function are_there(self)
    class(imposed_strains_t), intent(in) :: self

    are_there = .false.
    if (allocated(self%parts)) are_there = size(self%parts) > 0
  end function are_there

  !> Adds a part at the end.
  pure subroutine add_part(self, part)
    class(imposed_strains_t), intent(inout) :: self
    type(strain_part_t), intent(in) :: part
    type(strain_part_t), allocatable :: longer(:)
    integer :: n

    n = 0
    if (allocated(self%parts)) n = size(self%parts)
    allocate (longer(n + 1))
    if (n > 0) longer(:n) = self%parts
    longer(n + 1) = part
    call move_alloc(longer, self%parts)
  end subroutine add_part

  !> Makes a new part with those cells of this part that are in a list, and with their values. The new part may have no cells. The
  !> place in the deck is not copied.
  pure subroutine restrict(self, mesh, body, cells, part)
    class(strain_part_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> wanted cells, 1-based, in any order
    integer, intent(in) :: cells(:)
    type(strain_part_t), intent(out) :: part
    logical :: is_wanted(mesh%n_cells)
    integer :: i

    is_wanted = .false.
    is_wanted(cells) = .true.
    part%term = self%term
    part%material = self%material
    part%direction = self%direction
    part%cells = pack(self%cells, is_wanted(self%cells))
    part%values = pack(self%values, [(spread(is_wanted(self%cells(i)), 1, count_points(mesh, body, [self%cells(i)])), &
      i=1, size(self%cells))])
  end subroutine restrict

  !> Computes the imposed strains at all integration points from the values of the terms. If there are none, the arrays of `field`
  !> are not allocated. Local.
  pure subroutine evaluate(self, mesh, body, theta, field)
    class(imposed_strains_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> [-] values of self%terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(strain_field_t), intent(out) :: field
    integer :: i, i_part, i_point, n, n_points

    if (.not. self%are_there()) return
    call number_points(self, mesh, body, field%offsets)
    allocate (field%strains(n_stresses, field%offsets(mesh%n_cells + 1)), source=0.0_rk)
    do i_part = 1, size(self%parts)
      associate (part => self%parts(i_part))
        n = 0
        do i = 1, size(part%cells)
          n_points = count_points(mesh, body, [part%cells(i)])
          do i_point = 1, n_points
            associate (strain => field%strains(:, field%offsets(part%cells(i)) + i_point))
              strain = strain + theta(part%term) * part%values(n + i_point) * part%direction
            end associate
          end do
          n = n + n_points
        end do
      end associate
    end do
  end subroutine evaluate

  !> Numbers the integration points of the cells that are in some part: computes the offsets of strain_field_t.
  pure subroutine number_points(self, mesh, body, offsets)
    class(imposed_strains_t), intent(in) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    !> shape (n_cells + 1)
    integer, allocatable, intent(out) :: offsets(:)
    logical :: is_strained(mesh%n_cells)
    integer :: i

    is_strained = .false.
    do i = 1, size(self%parts)
      is_strained(self%parts(i)%cells) = .true.
    end do
    allocate (offsets(mesh%n_cells + 1), source=0)
    do i = 1, mesh%n_cells
      offsets(i + 1) = offsets(i) + merge(count_points(mesh, body, [i]), 0, is_strained(i))
    end do
  end subroutine number_points

  !> Returns the imposed strain [-] at an integration point, shears as angles; zero where nothing is imposed.
  pure function at_point(self, i_cell, i_point) result(strain)
    class(strain_field_t), intent(in) :: self
    !> 1-based
    integer, intent(in) :: i_cell
    !> 1-based among the integration points of the cell
    integer, intent(in) :: i_point
    real(rk) :: strain(n_stresses)

    strain = 0
    if (.not. allocated(self%offsets)) return
    if (self%offsets(i_cell + 1) > self%offsets(i_cell)) strain = self%strains(:, self%offsets(i_cell) + i_point)
  end function at_point

  !> Returns the mean imposed strain of each cell, weighted by volume, as components of the tensor: shears are half of the angles.
  !> It is zero where nothing is imposed. Local.
  pure function cell_strains(mesh, body, field) result(means)
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(strain_field_t), intent(in) :: field
    !> [-] shape (n_stresses, n_cells)
    real(rk) :: means(n_stresses, mesh%n_cells)
    real(rk) :: gradients(mesh%n_dim, maxval(mesh%cell_offsets(2:) - mesh%cell_offsets(:mesh%n_cells))), total, volume
    integer :: i_cell, i_point

    means = 0
    do i_cell = 1, mesh%n_cells
      total = 0
      associate (table => body%tables(body%table_of(i_cell, mesh%cell_types(i_cell))), nodes => nodes_of_cell(mesh, i_cell))
        do i_point = 1, table%n_points
          call physical_gradients(table, i_point, mesh%coordinates(:, nodes), gradients(:, :size(nodes)), volume)
          volume = volume * circumference(body%mechanics, matmul(mesh%coordinates(:, nodes), table%values(:, i_point)))
          means(:, i_cell) = means(:, i_cell) + volume * field%at_point(i_cell, i_point)
          total = total + volume
        end do
      end associate
      means(:, i_cell) = means(:, i_cell) / total
    end do
    means(4:, :) = means(4:, :) / 2
  end function cell_strains
end module sig_imposed_strain
