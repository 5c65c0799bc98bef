! SPDX-License-Identifier: BSD-3-Clause
!> The text of a first deck for a mesh: what can be read from the mesh, and places to fill in.
module sig_deck_draft
  use sig_bodies, only: find_bodies, regions_of_body
  use sig_deck_echo_words, only: yaml_text
  use sig_deck_unfilled, only: placeholder
  use sig_facing_groups, only: facing_groups_t
  use sig_file_system, only: base_name
  use sig_kinds, only: rk
  use sig_mesh, only: group_t, mesh_t
  use sig_region_cover, only: choose_regions, find_shared_nodes, shared_nodes_t
  use sig_surface_geometry, only: direction_text
  use sig_text, only: counted, join, short_number, string_t, to_text
  implicit none(type, external)
  private
  public :: draft_deck, drafted_model

  character(*), parameter :: axis_names = 'xyz'
  character(1), parameter :: nl = new_line('a')
  !> a mesh whose longest side is below this number is taken to be in m, another one in mm: few parts are shorter than 3 mm, few
  !> longer than 3 m
  real(rk), parameter :: shortest_in_mm = 3

contains

  !> Returns the text of a first deck, with comments that say what to do.
  function draft_deck(mesh, mesh_file, deck_file, pairs, why_not) result(text)
    type(mesh_t), intent(in) :: mesh
    !> path of the mesh as the deck shall name it
    character(*), intent(in) :: mesh_file
    !> path of the deck, for the comment that tells how to check it
    character(*), intent(in) :: deck_file
    !> pairs of mesh groups that may be in contact
    type(facing_groups_t), intent(in) :: pairs(:)
    !> why a pair can be no contact of the deck, of try_contacts
    type(string_t), intent(in) :: why_not(:)
    character(:), allocatable :: text

    text = '# Made by `signorom init`. Replace every ' // placeholder // ', then ask: signorom check ' // deck_file // &
      ' --fields' // nl // '# All keys of decks are listed in input/README.md.' // nl // &
      'title: ' // yaml_text(base_name(mesh_file)) // nl // nl // units_section(mesh) // nl // &
      mesh_section(mesh, mesh_file) // nl // &
      '# What varies and between which bounds; expressions below may use these names.' // nl // &
      'parameters:' // nl // &
      '  P: {min: ' // placeholder // ', max: ' // placeholder // ', unit: ' // trim(merge('Pa ', 'MPa', is_in_m(mesh))) // &
      '}' // nl // nl // material_section(mesh) // nl // boundary_section(mesh) // nl // &
      contact_section(mesh, pairs, why_not) // nl // &
      '# Points where the full-order problem is solved to train the model, and others to judge it.' // nl // &
      'training: {sobol: 100}' // nl // 'test: {sobol: 50, seed: 1}' // nl // &
      '# Points with fields for ParaView: output: {points: [{P: 10}]}' // nl
  end function draft_deck

  !> Whether the mesh is probably in m and not in mm, by its longest side.
  pure logical function is_in_m(mesh)
    type(mesh_t), intent(in) :: mesh

    is_in_m = longest_side(mesh) < shortest_in_mm
  end function is_in_m

  !> Returns the longest side [unit of the mesh] of the box around the mesh.
  pure real(rk) function longest_side(mesh)
    type(mesh_t), intent(in) :: mesh

    longest_side = maxval(maxval(mesh%coordinates, dim=2) - minval(mesh%coordinates, dim=2))
  end function longest_side

  function units_section(mesh) result(text)
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: text, unit

    unit = trim(merge('m ', 'mm', is_in_m(mesh)))
    text = '# The unit of length is guessed: the longest side of the mesh is ' // short_number(longest_side(mesh)) // &
      ', so it is probably in ' // unit // '. Change it if that is wrong.' // nl // &
      '# All numbers below carry these units: with mm and N, moduli and pressures are in MPa; with m and N, in Pa.' // nl // &
      'units: {length: ' // unit // ', force: N}' // nl
  end function units_section

  function mesh_section(mesh, mesh_file) result(text)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: mesh_file
    character(:), allocatable :: text
    integer, allocatable :: body_of_node(:)
    integer :: n_bodies

    call find_bodies(mesh, body_of_node, n_bodies)
    text = '# The mesh: ' // counted(mesh%n_nodes, 'node') // ', ' // counted(mesh%n_cells, 'cell') // ', ' // &
      to_text(n_bodies) // ' separate ' // trim(merge('body  ', 'bodies', n_bodies == 1)) // '; ' // &
      box_text(mesh%coordinates) // nl // shared_lines(mesh, mesh_file)
    if (mesh%n_dim == 2) then
      text = text // '# The model: plane_strain, plane_stress, or axisymmetric, where x of the mesh is the radius.' // nl
    end if
    text = text // 'mesh: {file: ' // yaml_text(mesh_file) // ', model: ' // drafted_model(mesh) // '}' // nl
  end function mesh_section

  !> Returns the mechanical model of the deck.
  pure function drafted_model(mesh) result(name)
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: name

    name = trim(merge('plane_strain', 'solid       ', mesh%n_dim == 2))
  end function drafted_model

  !> Returns a comment about each pair of regions that share nodes, with a line end: they are one body, also where they only touch
  !> in a line.
  function shared_lines(mesh, mesh_file) result(lines)
    type(mesh_t), intent(in) :: mesh
    character(*), intent(in) :: mesh_file
    character(:), allocatable :: lines
    type(shared_nodes_t), allocatable :: shared(:)
    integer :: i

    call find_shared_nodes(mesh, choose_regions(mesh), shared)
    lines = ''
    do i = 1, size(shared)
      associate (first => mesh%groups(shared(i)%first)%name, second => mesh%groups(shared(i)%second)%name)
        lines = lines // '# The regions ' // first // ' and ' // second // ' share ' // counted(shared(i)%n_nodes, 'node')
        if (.not. shared(i)%has_faces) lines = lines // ', but no ' // trim(merge('face', 'edge', mesh%n_dim == 3))
        lines = lines // ': they stick to each other there. If they may part:' // nl // &
          '#   signorom-post convert ' // mesh_file // " --split '" // first // "' '" // second // "' -o " // &
          base_name(mesh_file) // '_split.msh' // nl
      end associate
    end do
  end function shared_lines

  !> Returns the section materials: a material for each region of a set that covers the mesh once. Other names of the same cells
  !> are a comment.
  function material_section(mesh) result(text)
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: text, others
    integer, allocatable :: regions(:)
    integer :: i

    regions = choose_regions(mesh)
    others = ''
    text = '# A material per region of the mesh; one material may have several regions.' // nl // 'materials:' // nl
    do i = 1, size(mesh%groups)
      associate (group => mesh%groups(i))
        if (group%n_dim /= mesh%n_dim) cycle
        if (any(regions == i)) then
          text = text // '  ' // yaml_text(group%name) // ': {regions: [' // yaml_text(group%name) // '], young_modulus: ' // &
            placeholder // ', poisson_ratio: ' // placeholder // '}' // nl
        else
          others = others // ' ' // yaml_text(group%name)
        end if
      end associate
    end do
    if (len(others) > 0) text = text // '# Other names of the same cells:' // others // nl
  end function material_section

  !> Returns the sections boundary_conditions and loads, with places to fill in: the boundaries of the mesh as comments, those of
  !> larger dimension first, a support per body, and one load.
  function boundary_section(mesh) result(text)
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: text
    integer :: i, n_dim

    text = '# Boundaries of the mesh:' // nl
    do n_dim = mesh%n_dim - 1, 0, -1
      do i = 1, size(mesh%groups)
        associate (group => mesh%groups(i))
          if (group%n_dim /= n_dim .or. is_repeated(mesh, i) .or. is_part(mesh, i)) cycle
          text = text // '#   ' // yaml_text(group%name) // ': ' // box_text(mesh%coordinates(:, group%nodes)) // &
            other_names(mesh, i) // nl
        end associate
      end do
    end do
    text = text // '# Supports, an entry for each held boundary; components that are not named stay free.' // nl // &
      'boundary_conditions:' // nl // support_lines(mesh) // &
      '# Loads: pressure or traction: {y: ...}, as expressions of parameters and place.' // nl // &
      'loads:' // nl // '  - {boundary: ' // placeholder // ', pressure: P}' // nl
  end function boundary_section

  !> Whether an earlier group has the same elements as this one.
  pure logical function is_repeated(mesh, i_group)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    integer :: i

    is_repeated = any([(are_same(mesh%groups(i), mesh%groups(i_group)), i=1, i_group - 1)])
  end function is_repeated

  !> Whether a boundary of larger dimension has the name of this group, which then is that boundary's in a deck.
  pure logical function is_part(mesh, i_group)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    integer :: i

    associate (group => mesh%groups(i_group))
      is_part = any([(mesh%groups(i)%name == group%name .and. mesh%groups(i)%n_dim > group%n_dim .and. &
        mesh%groups(i)%n_dim < mesh%n_dim, i=1, size(mesh%groups))])
    end associate
  end function is_part

  !> Returns such as ` (also: top_2, lid)` with the names of later groups of the same elements; empty if there are none.
  function other_names(mesh, i_group) result(text)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: i_group
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = i_group + 1, size(mesh%groups)
      if (are_same(mesh%groups(i), mesh%groups(i_group))) text = text // ', ' // yaml_text(mesh%groups(i)%name)
    end do
    if (len(text) > 0) text = ' (also:' // text(2:) // ')'
  end function other_names

  !> Whether two groups have the same elements.
  pure logical function are_same(one, other)
    type(group_t), intent(in) :: one, other

    are_same = one%n_dim == other%n_dim .and. size(one%entities) == size(other%entities) .and. size(one%nodes) == size(other%nodes)
    if (are_same) are_same = all(one%entities == other%entities) .and. all(one%nodes == other%nodes)
  end function are_same

  !> Returns one line per body, with a line end, that holds all displacement components at a boundary to be filled in. With several
  !> bodies a comment names the regions of each.
  function support_lines(mesh) result(lines)
    type(mesh_t), intent(in) :: mesh
    character(:), allocatable :: lines
    integer, allocatable :: body_of_node(:)
    integer :: i, n_bodies

    call find_bodies(mesh, body_of_node, n_bodies)
    lines = ''
    do i = 1, n_bodies
      lines = lines // '  - {boundary: ' // placeholder // ', displacement: {' // held_components(mesh%n_dim) // '}}'
      if (n_bodies > 1) lines = lines // '  # of the body ' // join(regions_of_body(mesh, body_of_node, i), ', ') // &
        '; delete this line if contact alone holds it'
      lines = lines // nl
    end do
  end function support_lines

  pure function held_components(n_dim) result(text)
    integer, intent(in) :: n_dim
    character(:), allocatable :: text
    integer :: i

    text = 'x: 0'
    do i = 2, n_dim
      text = text // ', ' // axis_names(i:i) // ': 0'
    end do
  end function held_components

  !> Returns the section contact: the pairs that can be contacts, or a place to fill in; then, as comments, the pairs that cannot,
  !> with the reason.
  function contact_section(mesh, pairs, why_not) result(text)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), intent(in) :: pairs(:)
    type(string_t), intent(in) :: why_not(:)
    character(:), allocatable :: text
    integer, allocatable :: body_of_node(:)
    logical :: is_kept(size(pairs))
    integer :: i, n_bodies

    call find_bodies(mesh, body_of_node, n_bodies)
    if (n_bodies == 1) then
      text = '# A single body can touch a rigid obstacle: name its surface, a point of the plane, and the normal out of the ' // &
        'obstacle.' // nl // '# A sphere: {type: sphere, center: [...], radius: ...}, and direction: [...] from the surface ' // &
        'to it. Expressions may move both. If nothing touches the body, delete this section.' // nl // &
        'contact:' // nl // '  - {first: ' // placeholder // &
        ', obstacle: {type: half_space, point: [' // listed(mesh%n_dim) // '], normal: [' // listed(mesh%n_dim) // ']}}' // nl
      return
    end if
    is_kept = [(len(why_not(i)%text) == 0, i=1, size(pairs))]
    if (any(is_kept)) then
      text = '# Guessed from the mesh: surfaces of different bodies that face each other. Delete what cannot touch.' // nl // &
        'contact:' // nl
    else
      text = '# No two surfaces of different bodies face each other: name those that may touch, or delete this section.' // nl // &
        'contact:' // nl // &
        '  - {first: ' // placeholder // ', second: ' // placeholder // '}' // nl
    end if
    do i = 1, size(pairs)
      if (is_kept(i)) text = text // '  - ' // entry_of(mesh, pairs(i)) // '  # ' // to_text(nint(100 * pairs(i)%share)) // &
        ' % of the first surface faces the second' // gap_of(pairs(i)) // nl
    end do
    do i = 1, size(pairs)
      if (.not. is_kept(i)) text = text // '# Left out: ' // entry_of(mesh, pairs(i)) // ': ' // why_not(i)%text // nl
    end do
  end function contact_section

  !> Returns a pair as an entry of a deck.
  function entry_of(mesh, pair) result(text)
    type(mesh_t), intent(in) :: mesh
    type(facing_groups_t), intent(in) :: pair
    character(:), allocatable :: text

    text = '{first: ' // yaml_text(mesh%groups(pair%first)%name) // ', second: ' // &
      yaml_text(mesh%groups(pair%second)%name) // direction_of(pair, mesh%n_dim) // '}'
  end function entry_of

  !> Returns n places to fill in, with commas between them.
  pure function listed(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text

    text = placeholder // repeat(', ' // placeholder, n - 1)
  end function listed

  !> Returns `, gap about 0.1 to 0.2` for two flat surfaces, otherwise empty: the facets of curved surfaces are too coarse for it.
  pure function gap_of(pair) result(text)
    type(facing_groups_t), intent(in) :: pair
    character(:), allocatable :: text

    text = ''
    if (pair%is_flat) text = ', gap about ' // short_number(pair%gap(1)) // ' to ' // short_number(pair%gap(2))
  end function gap_of

  !> Returns `, direction: [0.0, 1.0]`, the direction that points into the second surface, if this surface is flat and the first one
  !> is curved: it stays right however far the bodies move. Otherwise empty.
  pure function direction_of(pair, n_dim) result(text)
    type(facing_groups_t), intent(in) :: pair
    integer, intent(in) :: n_dim
    character(:), allocatable :: text

    text = ''
    if (norm2(pair%direction) > 0) text = ', direction: ' // direction_text(pair%direction(:n_dim))
  end function direction_of

  !> Returns the box around the points: `x 0 to 1, y -2 to 0`; `touches no region` if there are no points.
  pure function box_text(points) result(text)
    !> [length of the mesh] shape (n_dim, n)
    real(rk), intent(in) :: points(:, :)
    character(:), allocatable :: text
    integer :: i

    text = 'touches no region'
    if (size(points, 2) == 0) return
    text = ''
    do i = 1, size(points, 1)
      if (i > 1) text = text // ', '
      text = text // axis_names(i:i) // ' ' // short_number(minval(points(i, :))) // ' to ' // short_number(maxval(points(i, :)))
    end do
  end function box_text
end module sig_deck_draft
