! SPDX-License-Identifier: BSD-3-Clause
!> The terms theta_t(mu) in which everything that depends on the parameters is linear: what they are made of, as data.
!>
!> theta_1 = 1. Every other term is a sum of sources: an expression of the parameters, an expression of the parameters and the
!> coordinates at fixed places, or the nodal forces of a surface load whose value or window depends on the parameters.
module sig_term_set
  use sig_kinds, only: rk
  use sig_text, only: append_text, string_t
  implicit none(type, external)
  private
  public :: term_set_t, term_source_t, start_terms
  public :: source_expression, source_places, source_surface

  integer, parameter :: source_expression = 1
  integer, parameter :: source_places = 2
  integer, parameter :: source_surface = 3

  type :: term_source_t
    integer :: kind = source_expression
    !> expression of the parameters and, but for source_expression, of the coordinates
    character(:), allocatable :: text
    !> source_expression: its one term; source_places: the term of each place
    integer, allocatable :: terms(:)
    !> [length] places, or the nodes of the surface; shape (n_dim, n_places)
    real(rk), allocatable :: places(:, :)
    !> source_surface: 0 = pressure, else component of a traction
    integer :: component = 0
    !> window: coordinate (0 = none), its bounds as expressions of the parameters (empty = none), cut or whole facets
    integer :: axis = 0
    character(:), allocatable :: minimum
    character(:), allocatable :: maximum
    logical :: is_cut = .true.
    !> places of each facet, filled up with 0, shape (4 or more, n_facets)
    integer, allocatable :: facets(:, :)
    !> +1 where the order of a facet's nodes gives the outward normal, else -1
    integer, allocatable :: orientations(:)
    !> terms of the nodal forces, 0 = none, shape (n_dim, n_places)
    integer, allocatable :: dof_terms(:, :)
    !> where the expression stands in the deck, for messages; not kept in a model
    integer :: line = 0
    integer :: column = 0
  end type term_source_t

  type :: term_set_t
    type(string_t), allocatable :: parameter_names(:)
    !> what expressions may call the coordinates: x, y, z or r, z
    type(string_t), allocatable :: coordinate_names(:)
    !> integrals carry 2 pi times the first coordinate
    logical :: is_round = .false.
    !> a few words or the expression for each term; the first is `1`
    type(string_t), allocatable :: names(:)
    type(term_source_t), allocatable :: sources(:)
  contains
    procedure :: n_terms
    procedure :: add_term
    procedure :: add_terms
    procedure :: add_expression
    procedure :: add_source
  end type term_set_t

contains

  !> Makes the set that holds term 1 only.
  pure subroutine start_terms(parameter_names, coordinate_names, is_round, terms)
    type(string_t), intent(in) :: parameter_names(:)
    type(string_t), intent(in) :: coordinate_names(:)
    logical, intent(in) :: is_round
    type(term_set_t), intent(out) :: terms

    terms%parameter_names = parameter_names
    terms%coordinate_names = coordinate_names
    terms%is_round = is_round
    allocate (terms%names(0), terms%sources(0))
    call append_text(terms%names, '1')
  end subroutine start_terms

  pure integer function n_terms(self)
    class(term_set_t), intent(in) :: self

    n_terms = 0
    if (allocated(self%names)) n_terms = size(self%names)
  end function n_terms

  !> Adds a new term, which is zero until a source adds to it.
  pure subroutine add_term(self, name, i_term)
    class(term_set_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer, intent(out) :: i_term

    call append_text(self%names, name)
    i_term = size(self%names)
  end subroutine add_term

  !> Adds several new terms at once, in the time that one takes.
  pure subroutine add_terms(self, names, terms)
    class(term_set_t), intent(inout) :: self
    type(string_t), intent(in) :: names(:)
    !> shape (size(names))
    integer, intent(out) :: terms(:)
    type(string_t), allocatable :: longer(:)
    integer :: i, n

    n = size(self%names)
    allocate (longer(n + size(names)))
    longer(:n) = self%names
    longer(n + 1:) = names
    call move_alloc(longer, self%names)
    terms = [(n + i, i=1, size(names))]
  end subroutine add_terms

  !> Adds a new term that is an expression of the parameters.
  pure subroutine add_expression(self, text, line, column, i_term)
    class(term_set_t), intent(inout) :: self
    character(*), intent(in) :: text
    integer, intent(in) :: line
    integer, intent(in) :: column
    integer, intent(out) :: i_term
    type(term_source_t) :: source

    call self%add_term(text, i_term)
    source%text = text
    source%terms = [i_term]
    source%line = line
    source%column = column
    call self%add_source(source)
  end subroutine add_expression

  !> Adds a source of existing terms; parts that it does not use become empty.
  pure subroutine add_source(self, source)
    class(term_set_t), intent(inout) :: self
    type(term_source_t), intent(in) :: source
    type(term_source_t), allocatable :: longer(:)
    integer :: i, n

    n = size(self%sources)
    allocate (longer(n + 1))
    do i = 1, n
      call move_source(self%sources(i), longer(i))
    end do
    longer(n + 1) = source
    associate (whole => longer(n + 1))
      if (.not. allocated(whole%terms)) allocate (whole%terms(0))
      if (.not. allocated(whole%places)) allocate (whole%places(size(self%coordinate_names), 0))
      if (.not. allocated(whole%minimum)) whole%minimum = ''
      if (.not. allocated(whole%maximum)) whole%maximum = ''
      if (.not. allocated(whole%facets)) allocate (whole%facets(4, 0))
      if (.not. allocated(whole%orientations)) allocate (whole%orientations(0))
      if (.not. allocated(whole%dof_terms)) allocate (whole%dof_terms(size(self%coordinate_names), 0))
    end associate
    call move_alloc(longer, self%sources)
  end subroutine add_source

  !> Moves a source without copying its arrays, because a deck may have thousands of sources.
  pure subroutine move_source(from, to)
    type(term_source_t), intent(inout) :: from
    type(term_source_t), intent(inout) :: to

    to%kind = from%kind
    to%component = from%component
    to%axis = from%axis
    to%is_cut = from%is_cut
    to%line = from%line
    to%column = from%column
    call move_alloc(from%text, to%text)
    call move_alloc(from%terms, to%terms)
    call move_alloc(from%places, to%places)
    call move_alloc(from%minimum, to%minimum)
    call move_alloc(from%maximum, to%maximum)
    call move_alloc(from%facets, to%facets)
    call move_alloc(from%orientations, to%orientations)
    call move_alloc(from%dof_terms, to%dof_terms)
  end subroutine move_source
end module sig_term_set
